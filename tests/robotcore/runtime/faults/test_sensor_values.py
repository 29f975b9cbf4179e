from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.hal.clock import SteppedClock
from robotcore.kinds.range_sensor import Range
from tests.robotcore.fakes import NullEncoder, Rig, picture
from tests.robotcore.runtime.faults.rigs import TICK_S, build_rig, layers


def readings(rig: Rig, ticks: int) -> list[Range]:
    found = []
    for _ in range(ticks):
        found.append(rig.robot.range.read())
        rig.sleep(TICK_S)
    return found


class TestRangeNoise:
    def test_noise_has_the_given_deviation_and_no_bias(self) -> None:
        rig = build_rig("range noise=0.05")
        rig.nose.distance = 1.0
        distances = [reading.distance for reading in readings(rig, 500)]
        assert np.std(distances) == pytest.approx(0.05, rel=0.1)
        assert np.mean(distances) == pytest.approx(1.0, abs=0.01)

    def test_infinite_distances_stay_infinite(self) -> None:
        assert all(math.isinf(reading.distance) for reading in readings(build_rig("range noise=1"), 20))


class TestRangeBias:
    def test_bias_is_added_within_the_sensors_range(self) -> None:
        for distance, read in ((1.0, 0.75), (0.2, 0.02), (math.inf, math.inf)):
            rig = build_rig("range bias=-0.25")
            rig.nose.distance = distance
            assert rig.robot.range.read().distance == read


class TestStuck:
    def test_sample_has_the_stuck_distance_a_new_time_and_no_point(self) -> None:
        rig = build_rig("range stuck=1.5 after=0.1 lasts=0.1")
        rig.nose.distance = 0.3
        found = readings(rig, 6)
        assert [reading.distance for reading in found] == [0.3, 0.3, 1.5, 1.5, 0.3, 0.3]
        assert [reading.sequence for reading in found] == [1, 2, 3, 4, 5, 6]
        rig.nose._newest = lambda: Range(0.3, 0.1, 7, (0.3, 0.0, 0.0))  # type: ignore[method-assign]
        assert rig.robot.range.read().point is None

    @pytest.mark.parametrize("given, read", [(2.5, math.inf), (0.001, 0.02)])
    def test_stuck_distance_is_limited_to_the_sensors_range(self, given: float, read: float) -> None:
        assert build_rig(f"range stuck={given}").robot.range.read().distance == read


class TestSpikes:
    def test_spikes_have_the_given_share_and_span_the_sensors_range(self) -> None:
        rig = build_rig("range spikes=0.3")
        rig.nose.distance = 1.0
        spikes = [reading.distance for reading in readings(rig, 1000) if reading.distance != 1.0]
        assert len(spikes) == pytest.approx(300, abs=45)
        assert 0.02 <= min(spikes) < 0.1
        assert 1.9 < max(spikes) <= 2.0


class TestCameraNoise:
    def test_frames_are_noisy_only_during_the_fault(self) -> None:
        rig = build_rig("camera noise=20 after=0.05 lasts=0.05")
        rig.eye.image = picture((128, 128, 128))
        deviations = []
        for _ in range(3):
            frame = rig.robot.camera.read()
            assert not frame.image.flags.writeable
            deviations.append(float(np.std(frame.image)))
            rig.sleep(TICK_S)
        assert deviations == pytest.approx([0.0, 20.0, 0.0], rel=0.05)


class TestSlip:
    @pytest.mark.parametrize("turn", [1.0, -1.0])
    def test_encoder_misses_a_share_of_the_turn_during_the_fault(self, turn: float) -> None:
        clock = SteppedClock(20, lambda _: None)
        encoder = NullEncoder(clock, "left_encoder")
        (layer,) = layers("left_encoder slip=0.25 after=0.1 lasts=0.1", clock=clock)
        read, angles = layer.sensor(encoder, encoder.read), []
        for _ in range(6):
            angles.append(read().angle)
            encoder.angle += turn
            clock.sleep_until(clock.now() + TICK_S)
        assert [angle / turn for angle in angles] == pytest.approx([0.0, 1.0, 2.0, 2.75, 3.5, 4.5])

from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.hal.devices import Range
from tests.robotcore.fakes import Rig, picture
from tests.robotcore.runtime.faults.rigs import TICK_S, Odometer, faulty


def readings(rig: Rig, ticks: int) -> list[Range]:
    found = []
    for _ in range(ticks):
        found.append(rig.robot.range.read())
        rig.sleep(TICK_S)
    return found


class TestRangeNoise:
    def test_it_is_normal_and_of_its_deviation(self) -> None:
        rig = faulty("range noise=0.05")
        rig.nose.distance = 1.0
        distances = [reading.distance for reading in readings(rig, 500)]
        assert np.std(distances) == pytest.approx(0.05, rel=0.1)
        assert np.mean(distances) == pytest.approx(1.0, abs=0.01)

    def test_where_nothing_is_in_range_nothing_is(self) -> None:
        assert all(math.isinf(reading.distance) for reading in readings(faulty("range noise=1"), 20))


class TestStuck:
    def test_an_old_distance_comes_with_a_new_time_and_number_and_without_a_point(self) -> None:
        rig = faulty("range stuck=1.5 after=0.1 lasts=0.1")
        rig.nose.distance = 0.3
        found = readings(rig, 6)
        assert [reading.distance for reading in found] == [0.3, 0.3, 1.5, 1.5, 0.3, 0.3]
        assert [reading.sequence for reading in found] == [1, 2, 3, 4, 5, 6]
        rig.nose._newest = lambda: Range(0.3, 0.1, 7, (0.3, 0.0, 0.0))  # type: ignore[method-assign]
        assert rig.robot.range.read().point is None

    @pytest.mark.parametrize("given, read", [(2.5, math.inf), (0.001, 0.02)])
    def test_it_stays_what_the_sensor_could_say(self, given: float, read: float) -> None:
        assert faulty(f"range stuck={given}").robot.range.read().distance == read

    def test_the_guard_believes_it(self) -> None:
        rig = faulty("range stuck=1.5")
        rig.nose.distance = 0.05
        assert rig.robot.drive.set_velocity(0.2, 0.0).linear == pytest.approx(0.2)


class TestSpikes:
    def test_so_many_are_false_and_lie_anywhere_in_range(self) -> None:
        rig = faulty("range spikes=0.3")
        rig.nose.distance = 1.0
        spikes = [reading.distance for reading in readings(rig, 1000) if reading.distance != 1.0]
        assert len(spikes) == pytest.approx(300, abs=45)
        assert 0.02 <= min(spikes) < 0.1
        assert 1.9 < max(spikes) <= 2.0


class TestCameraNoise:
    def test_pictures_are_noisy_while_it_is_there(self) -> None:
        rig = faulty("camera noise=20 after=0.05 lasts=0.05")
        rig.eye.image = picture((128, 128, 128))
        deviations = []
        for _ in range(3):
            frame = rig.robot.camera.read()
            assert not frame.image.flags.writeable
            deviations.append(float(np.std(frame.image)))
            rig.sleep(TICK_S)
        assert deviations == pytest.approx([0.0, 20.0, 0.0], rel=0.05)

    def test_each_frame_has_its_own(self) -> None:
        rig = faulty("camera noise=20")
        first = rig.robot.camera.read().image
        rig.sleep(TICK_S)
        assert not np.array_equal(first, rig.robot.camera.read().image)


class TestSlip:
    def test_a_share_is_missed_of_what_the_wheel_turns_meanwhile_and_never_made_good(self) -> None:
        odometer = Odometer("left_encoder slip=0.25 after=0.1 lasts=0.1")
        angles = []
        for _ in range(6):
            angles.append(odometer.angle)
            odometer.turn(1.0)
        assert angles == pytest.approx([0.0, 1.0, 2.0, 2.75, 3.5, 4.5])

    def test_it_is_the_same_whether_or_not_somebody_reads(self) -> None:
        odometer = Odometer("encoders slip=0.25 after=0.1 lasts=0.1")
        for _ in range(5):
            odometer.turn(1.0)
        assert odometer.angle == pytest.approx(4.5)

    def test_backwards_it_misses_too(self) -> None:
        odometer = Odometer("left_encoder slip=0.5")
        odometer.turn(-2.0)
        assert odometer.angle == pytest.approx(-1.0)

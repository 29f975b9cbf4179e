from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.description import Mount, load_robot
from robotcore.errors import DeviceError
from robotcore.geometry import DifferentialGeometry, Twist, Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.hal.joint import Joints
from robotcore.kinds.servo import ServoDescription
from robotcore.safety.range_guard import DistanceAhead, RangeGuard, compute_stopping_distance
from robotcore.safety.sensor_ahead import SensorAhead
from tests.robotcore.fakes import NullRange, look_ahead
from tests.texts import Raises

GEOMETRY = DifferentialGeometry(wheel_radius=0.05, track=0.2)
STOPPED = Wheels(0.0, 0.0)


def stand() -> Twist:
    return Twist(0.0, 0.0)


wheels = st.builds(Wheels, st.floats(-100, 100), st.floats(-100, 100))


class TestRangeGuard:
    def test_stopping_distance_grows_with_the_square_of_the_speed(self) -> None:
        assert compute_stopping_distance(0.0, 0.1, 0.5) == 0.1
        assert compute_stopping_distance(0.4, 0.1, 0.5) == pytest.approx(0.1 + 0.16)

    @pytest.mark.parametrize("speed", [0.05, 0.2, 0.4])
    def test_guard_acts_exactly_at_the_stopping_distance(self, speed: float) -> None:
        limit = 0.10 + speed**2 / (2 * 0.5)
        asked = GEOMETRY.to_wheels(speed, 0.0)
        assert _guard(limit + 1e-9)(asked, STOPPED) == asked
        assert _guard(limit - 1e-9)(asked, STOPPED) == (0.0, 0.0)

    @given(st.floats(-0.4, 0.4), st.floats(-5, 5), st.floats(0, 2))
    def test_guard_keeps_the_distance_and_the_turn_for_any_command(
        self, linear: float, angular: float, distance: float
    ) -> None:
        sent = GEOMETRY.to_twist(_guard(distance)(GEOMETRY.to_wheels(linear, angular), STOPPED))
        assert sent.angular == pytest.approx(angular, abs=1e-9)
        assert distance >= compute_stopping_distance(sent.linear, 0.10, 0.5) - 1e-9 or sent.linear <= 1e-12
        assert sent.linear == pytest.approx(linear, abs=1e-12) or linear > 0

    @pytest.mark.parametrize("linear", [0.0, -0.3])
    def test_guard_reads_no_distance_unless_the_robot_moves_forward(self, linear: float) -> None:
        guard = RangeGuard(GEOMETRY, lambda _: pytest.fail("asked"), 0.10, 0.5)
        asked = GEOMETRY.to_wheels(linear, 2.0)
        assert guard(asked, STOPPED) == asked


def _guard(distance: float) -> RangeGuard:
    return RangeGuard(GEOMETRY, lambda _: distance, 0.10, 0.5)


class ServoBench:
    """A range sensor on a servo, which turns by 2 rad in a second."""

    def __init__(self) -> None:
        self._clock = SteppedClock(20, lambda _: None)
        self.nose = NullRange(self._clock, distance=0.3)
        rover = load_robot("rover")
        servo = ServoDescription(
            kind="servo", name="pan", mount=Mount(z_m=0.1), min_angle_rad=-2, max_angle_rad=2, max_velocity_rad_s=2
        )
        on_servo = rover.sensors_ahead[0].model_copy(update={"mount": Mount(z_m=0.1, on="pan")})
        robot = rover.model_copy(update={"devices": (servo, on_servo)})
        self._joints = Joints(robot, self._clock)
        self.moved = Twist(0.0, 0.0)
        sensors = [SensorAhead(self.nose, robot, self._joints)]
        self.ahead = DistanceAhead(self._clock, sensors, lambda: self.moved)

    def turn(self, angle: float) -> None:
        """Turn the servo, and wait a second."""
        self._joints["pan"].turn_to(angle)
        self._clock.sleep_until(self._clock.now() + 1.0)


class TestDistanceAhead:
    def test_distance_driven_since_a_reading_is_subtracted(self) -> None:
        clock = SteppedClock(20, lambda _: None)
        nose = NullRange(clock, distance=0.5)
        nose.age = 0.4
        assert DistanceAhead(clock, [look_ahead(nose, clock)], stand)(0.25) == pytest.approx(0.5 - 0.4 * 0.25)
        assert DistanceAhead(clock, [look_ahead(nose, clock)], stand)(0.0) == 0.5

    def test_highest_speed_since_a_reading_counts(self) -> None:
        clock = SteppedClock(20, lambda _: None)
        nose = NullRange(clock, distance=0.5)
        ahead = DistanceAhead(clock, [look_ahead(nose, clock)], stand)
        nose.age = 0.2
        assert ahead(0.4) == pytest.approx(0.5 - 0.2 * 0.4)
        nose.reads -= 1  # the same sample once more, older and after braking
        nose.age = 0.6
        assert ahead(0.1) == pytest.approx(0.5 - 0.6 * 0.4)
        assert ahead(0.1) == pytest.approx(0.5 - 0.6 * 0.1)

    def test_reading_newer_than_the_tick_adds_no_distance(self) -> None:
        clock = SteppedClock(20, lambda _: None)
        nose = NullRange(clock, distance=0.17)
        nose.age = -0.08
        assert DistanceAhead(clock, [look_ahead(nose, clock)], stand)(0.25) == 0.17

    def test_nearest_of_several_readings_counts(self) -> None:
        clock = SteppedClock(20, lambda _: None)
        sensors = [look_ahead(NullRange(clock, distance=distance), clock) for distance in (math.inf, 0.3, 0.9)]
        assert DistanceAhead(clock, sensors, stand)(0.1) == 0.3

    @pytest.mark.parametrize("distances", [(math.nan, math.inf), (math.inf, math.nan)])
    def test_reading_that_is_no_number_leaves_no_distance(self, distances: tuple[float, float]) -> None:
        clock = SteppedClock(20, lambda _: None)
        sensors = [look_ahead(NullRange(clock, distance=distance), clock) for distance in distances]
        assert DistanceAhead(clock, sensors, stand)(0.1) == 0.0

    @pytest.mark.parametrize("measure", [lambda *_: None, lambda *_: 1 / 0], ids=["none", "fails"])
    def test_class_that_measures_no_distance_is_an_error_of_the_device(
        self, measure: Callable[..., float], raises: Raises
    ) -> None:
        clock = SteppedClock(20, lambda _: None)
        nose = NullRange(clock, distance=0.3)
        nose.measure_ahead = measure  # type: ignore[method-assign]
        with raises(DeviceError, "driver-error", device="nose"):
            DistanceAhead(clock, [look_ahead(nose, clock)], stand)(0.1)

    def test_sensor_that_is_turned_aside_is_not_read(self) -> None:
        bench = ServoBench()
        assert bench.ahead(0.1) == 0.3
        bench.turn(math.pi / 2)
        assert (bench.ahead(0.1), bench.nose.reads) == (0.3, 1)

    def test_robot_whose_sensors_look_aside_has_only_the_distance_that_they_saw(self) -> None:
        bench = ServoBench()
        assert bench.ahead(0.1) == 0.3
        bench.turn(math.pi / 2)
        bench.moved = Twist(0.2, 0.5)
        assert bench.ahead(0.1) == pytest.approx(0.1)
        bench.moved = Twist(-1.0, -0.5)
        assert bench.ahead(0.1) == 0.3
        bench.moved = Twist(0.2, 1.0)
        assert bench.ahead(0.1) == 0.0

    def test_reading_without_an_echo_covers_the_range_of_the_sensor(self) -> None:
        bench = ServoBench()
        bench.nose.distance = math.inf
        assert bench.ahead(0.1) == math.inf
        bench.turn(math.pi / 2)
        assert bench.ahead(0.1) == bench.nose.max_range

    def test_only_a_reading_straight_ahead_counts_after_the_sensor_has_turned_aside(self) -> None:
        bench = ServoBench()
        bench.turn(0.7)
        assert bench.ahead(0.1) == 0.3
        bench.turn(math.pi / 2)
        assert bench.ahead(0.1) == 0.0

    def test_sample_from_before_the_sensor_looked_ahead_does_not_count(self) -> None:
        bench = ServoBench()
        bench.turn(math.pi / 2)
        bench.turn(0.0)
        bench.nose.age = 0.9
        assert bench.ahead(0.1) == 0.0
        bench.nose.age = 0.1
        assert bench.ahead(0.1) == pytest.approx(0.3 - 0.1 * 0.1)

    def test_guard_uses_the_faster_of_the_new_and_the_last_command(self) -> None:
        speeds: list[float] = []
        guard = RangeGuard(GEOMETRY, lambda speed: speeds.append(speed) or math.inf, 0.10, 0.5)  # type: ignore[func-returns-value]
        guard(GEOMETRY.to_wheels(0.1, 0.0), GEOMETRY.to_wheels(0.3, 0.0))
        guard(GEOMETRY.to_wheels(0.2, 0.0), STOPPED)
        assert speeds == pytest.approx([0.3, 0.2])

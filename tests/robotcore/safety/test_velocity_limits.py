from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.geometry import Wheels
from robotcore.safety.velocity_limits import AccelerationLimit, ArcAccelerationLimit, SteeringLimit, VelocityLimit

STOPPED = Wheels(0.0, 0.0)
wheels = st.builds(Wheels, st.floats(-100, 100), st.floats(-100, 100))


class TestVelocityLimit:
    def test_command_within_the_limit_passes(self) -> None:
        assert VelocityLimit(10.0)(Wheels(10.0, -10.0), STOPPED) == (10.0, -10.0)

    @given(wheels)
    def test_result_keeps_the_path_and_the_limit(self, asked: Wheels) -> None:
        sent = VelocityLimit(10.0)(asked, STOPPED)
        assert max(map(abs, sent)) <= 10.0 + 1e-9
        assert sent.left * asked.right == pytest.approx(sent.right * asked.left, abs=1e-6)
        assert sent.left * asked.left >= 0


class TestAccelerationLimit:
    def test_change_within_the_limit_passes(self) -> None:
        assert AccelerationLimit(2.0)(Wheels(5.0, 3.0), Wheels(3.0, 5.0)) == (5.0, 3.0)

    def test_both_changes_are_scaled_by_one_factor(self) -> None:
        assert AccelerationLimit(2.0)(Wheels(9.0, 4.0), Wheels(1.0, 2.0)) == (3.0, 2.5)

    @given(wheels, wheels)
    def test_each_wheel_comes_nearer_to_the_command_within_the_limit(self, asked: Wheels, last: Wheels) -> None:
        sent = AccelerationLimit(2.0)(asked, last)
        for got, wanted, before in zip(sent, asked, last, strict=True):
            assert abs(got - before) <= 2.0 + 1e-9
            assert abs(wanted - got) <= abs(wanted - before) + 1e-9


@pytest.mark.parametrize(
    "last, command, expected",
    [
        ((3.0, 5.0), (6.0, 6.0), (6.0, 6.0)),
        ((3.0, 5.0), (10.0, 6.0), (7.5, 4.5)),  # the new arc
        ((3.0, 5.0), (-6.0, -4.0), (1.5, 2.5)),  # the last arc
        ((0.75, 1.25), (-6.0, -4.0), (-1.2, -0.8)),  # the new arc, backward
        ((1.5, 2.5), (-6.0, -4.0), (0.0, 0.0)),
        ((3.0, 5.0), (0.0, 0.0), (1.5, 2.5)),
        ((0.0, 0.0), (3.0, 5.0), (1.5, 2.5)),
    ],
)
def test_robot_that_steers_brakes_on_its_last_arc_and_accelerates_on_the_new_one(
    last: tuple[float, float], command: tuple[float, float], expected: tuple[float, float]
) -> None:
    assert ArcAccelerationLimit(2.0)(Wheels(*command), Wheels(*last)) == pytest.approx(expected)


@pytest.mark.parametrize(
    "command, expected, cause",
    [
        ((3.0, 5.0), (3.0, 5.0), ""),
        ((2.0, 6.0), (3.0, 5.0), "steering limit"),
        ((6.0, 2.0), (6.0, 2.0), ""),
        ((7.0, 1.0), (6.0, 2.0), "steering limit"),
        ((-6.0, -2.0), (-6.0, -2.0), ""),  # backward with the wheels to the right
        ((-2.0, -6.0), (-3.0, -5.0), "steering limit"),
        ((0.0, 8.0), (3.0, 5.0), "steering limit"),
        ((-1.0, 1.0), (0.0, 0.0), "turn on the spot"),
        ((0.0, 0.0), (0.0, 0.0), ""),
    ],
)
def test_steering_limit_keeps_the_speed_and_the_side_of_the_turn(
    command: tuple[float, float], expected: tuple[float, float], cause: str
) -> None:
    limit = SteeringLimit(least=-0.5, greatest=0.25)  # sharper to the right
    limited = limit(Wheels(*command), STOPPED)
    assert limited == Wheels(*expected)
    assert not cause or limit.cause == cause


@pytest.mark.parametrize("speed", [1e-12, 0.1, 3.0, -7.0])
def test_sharpest_turn_is_left_unchanged_at_every_speed(speed: float) -> None:
    limit = SteeringLimit(-0.3, 0.3)
    command = Wheels(speed * (1 - 0.3), speed * (1 + 0.3))
    assert limit(command, STOPPED) is command

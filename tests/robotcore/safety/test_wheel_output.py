from __future__ import annotations

import pytest

from robotcore.errors import DeviceError
from robotcore.geometry import Wheels
from robotcore.safety.wheel_output import AxleMotor, SideMotors, SteeredWheels
from tests.robotcore.fakes import NullMotor


def test_motors_of_a_side_get_the_same_velocity() -> None:
    left, right = [NullMotor("a"), NullMotor("b")], [NullMotor("c"), NullMotor("d")]
    output = SideMotors(left, right)
    assert output.set_wheels(Wheels(2.0, 3.0)) == Wheels(2.0, 3.0)
    assert [motor.sent for motor in (*left, *right)] == [[2.0], [2.0], [3.0], [3.0]]
    assert output.names == ("a, b", "c, d")


@pytest.mark.parametrize("broken", ["a", "b", "c", "d"])
def test_error_of_a_driver_names_its_motor(broken: str) -> None:
    def fail(_: float) -> None:
        raise OSError("no bus")

    motors = {name: NullMotor(name) for name in "abcd"}
    motors[broken].on_command = fail
    output = SideMotors([motors["a"], motors["b"]], [motors["c"], motors["d"]])
    with pytest.raises(DeviceError, match=f"^{broken}: "):
        output.set_wheels(Wheels(2.0, 3.0))


@pytest.mark.parametrize("wheels", [Wheels(2.0, 4.0), Wheels(0.0, 0.0), Wheels(-4.0, -2.0)])
def test_motor_with_a_differential_gear_gets_the_mean(wheels: Wheels) -> None:
    motor = NullMotor("drive")
    assert AxleMotor(motor).set_wheels(wheels) == wheels
    assert motor.sent == [(wheels.left + wheels.right) / 2]


def test_limit_of_a_motor_with_a_differential_gear_keeps_the_arc() -> None:
    motor = NullMotor("drive", max_velocity=3.0)
    assert AxleMotor(motor).set_wheels(Wheels(4.0, 8.0)) == Wheels(2.0, 4.0)


def test_steering_comes_before_the_motors_and_holds_at_rest() -> None:
    calls: list[float] = []
    motor = NullMotor("drive")
    motor.on_command = lambda _: calls.append(0.0)
    output = SteeredWheels(AxleMotor(motor), calls.append, track=0.1)
    output.set_wheels(Wheels(3.0, 5.0))
    assert calls == [pytest.approx(2 * 2 / (8 * 0.1)), 0.0]
    output.set_wheels(Wheels(0.0, 0.0))
    assert len(calls) == 3


def test_least_command_of_all_has_a_curvature() -> None:
    curvatures: list[float] = []
    SteeredWheels(AxleMotor(NullMotor("drive")), curvatures.append, track=0.1).set_wheels(Wheels(5e-324, 5e-324))
    assert curvatures == [0.0]

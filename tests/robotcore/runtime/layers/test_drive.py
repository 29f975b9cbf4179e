"""The motors of an app: the wheels of the drive, and a gripper that belongs to no drive."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from robotcore.errors import DeviceClosedError, EmergencyStopError, InvalidCommandError, UsageError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.safety.latch import EmergencyStop
from tests.robotcore.fakes import ROVER, UNHURRIED, NullMotor, Rig
from tests.texts import Raises


def test_command_for_one_wheel_of_the_drive_is_refused(raises: Raises) -> None:
    rig = Rig(description=UNHURRIED)
    with raises(UsageError, "wheel-of-the-drive", device="left_motor"):
        rig.robot.motors["left_motor"].set_velocity(1.0)
    rig.commit()
    assert rig.left.sent == []


def test_invalid_command_for_one_wheel_of_the_drive_stops_the_robot_for_ever() -> None:
    rig = Rig(description=UNHURRIED)
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    with pytest.raises(InvalidCommandError):
        rig.robot.motors["left_motor"].set_velocity(math.nan)
    assert rig.wheels == (0.0, 0.0)
    with pytest.raises(InvalidCommandError):
        rig.robot.drive.set_wheels(1.0, 2.0)


def test_stop_of_one_wheel_stops_the_robot_at_once() -> None:
    rig = Rig(description=UNHURRIED)
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    rig.robot.motors["left_motor"].stop()
    assert rig.wheels == (0.0, 0.0)


GRIPPER = MotorDescription(kind="motor", name="gripper", max_velocity_rad_s=3.0)
HANDY = ROVER.model_copy(update={"devices": (*ROVER.devices, GRIPPER)})


class Bench:
    """A rover with a gripper, a motor that belongs to no drive."""

    def __init__(self) -> None:
        self.inner, self.wheel = NullMotor("gripper", 3.0), NullMotor("left_motor")
        self.raw_clock = SteppedClock(20, lambda _: None)
        self.assembled: AssembledRobot = assemble(
            Robot("rover", self.raw_clock, [self.inner, self.wheel, NullMotor("right_motor")]), HANDY, 20
        )
        gripper = self.assembled.robot["gripper"]
        assert isinstance(gripper, Motor)
        self.gripper = gripper

    def sleep(self, seconds: float) -> None:
        clock = self.assembled.clock
        clock.sleep_until(clock.now() + seconds)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_command_is_sent_at_once_and_limited(bench: Bench) -> None:
    assert bench.gripper.set_velocity(2.0) == 2.0
    assert bench.gripper.set_velocity(9.0) == 3.0
    assert bench.inner.sent == [2.0, 3.0]


def test_command_expires_after_one_lease_unless_it_is_renewed(bench: Bench) -> None:
    for _ in range(10):
        bench.gripper.set_velocity(2.0)
        bench.sleep(0.05)
    assert 0.0 not in bench.inner.sent
    bench.sleep(0.07)
    assert 0.0 not in bench.inner.sent
    bench.sleep(0.02)
    assert bench.inner.sent[-1] == 0.0


@pytest.mark.parametrize("velocity", [math.nan, math.inf])
def test_velocity_that_is_nan_stops_every_motor_until_the_end(bench: Bench, velocity: float) -> None:
    with pytest.raises(InvalidCommandError):
        bench.gripper.set_velocity(velocity)
    assert bench.wheel.sent[-1] == bench.inner.sent[-1] == 0.0
    with pytest.raises(InvalidCommandError):
        bench.gripper.set_velocity(1.0)
    assert set(bench.inner.sent) == {0.0}


def test_e_stop_stops_the_motor_until_the_end(bench: Bench) -> None:
    bench.gripper.set_velocity(2.0)
    EmergencyStop(bench.assembled.latch).press("the button")
    assert bench.inner.sent[-1] == 0.0
    with pytest.raises(EmergencyStopError):
        bench.gripper.set_velocity(1.0)


@pytest.mark.parametrize("moment", ["check", "call"])
def test_e_stop_during_a_command_stops_the_motor(bench: Bench, moment: str, monkeypatch: pytest.MonkeyPatch) -> None:
    latch = bench.assembled.latch
    stop = EmergencyStop(latch)
    if moment == "check":  # the button is pressed between the check and the call
        monkeypatch.setattr(latch, "check", lambda: stop.press("the button"))
    else:
        bench.inner.on_command = lambda rad_s: stop.press("the button") if rad_s else None
    assert bench.gripper.set_velocity(2.0) == 0.0
    assert bench.inner.sent[-1] == 0.0


def test_command_after_the_lease_in_the_same_tick_is_not_sent(bench: Bench) -> None:
    bench.gripper.set_velocity(2.0)
    bench.raw_clock.sleep_until(0.5)  # a step that hangs: the tick's own time stands still
    assert bench.gripper.set_velocity(2.0) == 0.0
    assert bench.inner.sent == [2.0, 0.0, 0.0]
    bench.sleep(1.0)
    assert bench.gripper.set_velocity(2.0) == 2.0


def test_later_change_of_an_array_does_not_change_a_command(bench: Bench) -> None:
    speeds: Any = np.array([2.0])
    bench.gripper.set_velocity(speeds[0, ...])
    speeds *= 500
    assert bench.inner.sent == [2.0]
    assert type(bench.inner.sent[0]) is float


def test_zero_is_a_stop(bench: Bench) -> None:
    bench.gripper.set_velocity(2.0)
    assert bench.gripper.set_velocity(0.0) == 0.0
    bench.sleep(1.0)
    assert bench.inner.sent == [2.0, 0.0]


def test_closed_motor_refuses_commands_and_accepts_stops(bench: Bench) -> None:
    bench.assembled.robot.close()
    bench.gripper.stop()
    with pytest.raises(DeviceClosedError):
        bench.gripper.set_velocity(1.0)
    assert bench.inner.releases == 1

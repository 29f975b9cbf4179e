"""Drivers with cutoffs, of which some stop nothing."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.kinematic.backend import KinematicBackend
from robotcore.hal.backend import Setup
from robotcore.hal.cutoff import Cutoff, CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor
from tests.robotcore.testing.harness import Sound, broken

_motors: dict[str, Motor] = {}


class StopMotor(Cutoff):
    """Stops a motor of the robot that was opened last."""

    def __init__(self, motor: str) -> None:
        self._motor = motor

    def open(self) -> None:
        """Do nothing, because the robot is in the same process."""

    def stop(self) -> None:
        _motors[self._motor].stop()

    def close(self) -> None:
        """Do nothing, because the robot is in the same process."""


class StopNothing(StopMotor):
    """Reports a stop that did not happen."""

    def stop(self) -> None:
        """Do nothing."""


class FailToStop(StopMotor):
    """Fails."""

    def stop(self) -> None:
        raise OSError("no such line")


class StoppableBackend(KinematicBackend):
    capabilities = frozenset()

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        return _list_cutoffs(StopMotor)


class CutoffSuite(Sound):
    """A suite on a robot whose wheel motors have cutoffs of the classes ``left`` and ``right``."""

    backend = StoppableBackend
    left: type[Cutoff] = StopMotor
    right: type[Cutoff] = StopMotor

    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        _motors.update(robot.motors)
        if robot.motors:
            robot.cutoffs = tuple(_list_cutoffs(self.left, self.right))
        return robot


class IdleSuite(CutoffSuite):
    left = right = StopNothing


class HalfIdleSuite(CutoffSuite):
    right = StopNothing


class FailingSuite(CutoffSuite):
    left = right = FailToStop


class ForgetfulBackend(StoppableBackend):
    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        return ()


class ForgetfulSuite(CutoffSuite):
    backend = ForgetfulBackend


def _list_cutoffs(*classes: type[Cutoff]) -> list[CutoffSpec]:
    return [
        CutoffSpec(motor, f"{__name__}:{each.__name__}", {"motor": motor})
        for motor, each in zip(("left_motor", "right_motor"), classes * 2, strict=False)
    ]


_RULE = "cutoffs_bring_the_wheels_to_rest"

BROKEN = (
    broken("the cutoffs stop nothing", _RULE, suite=IdleSuite),
    broken("one cutoff stops nothing", _RULE, suite=HalfIdleSuite),
    broken("the cutoffs fail", _RULE, suite=FailingSuite),
    broken(
        "only a run has cutoffs, not robotcore stop", "robotcore_stop_has_the_cutoffs_of_a_run", suite=ForgetfulSuite
    ),
)

"""A robot for unit tests of apps."""

from __future__ import annotations

import math
from collections.abc import Mapping

from drivers.mock.backend import MockBackend
from drivers.mock.devices import MockDisplay, MockMotor
from drivers.mock.script import Script
from robotcore.backend import Setup
from robotcore.behaviour import Behaviour, Status
from robotcore.description import (
    CameraDescription,
    Described,
    RangeSensorDescription,
    RobotDescription,
    load_robot,
)
from robotcore.devices import Image
from robotcore.drive import Wheels
from robotcore.errors import UsageError
from robotcore.layers import Assembled, assemble, needed_devices
from robotcore.loop import Loop
from robotcore.robot import Robot
from robotcore.trace import TickRecord


class MockRobot:
    """Runs an app tick by tick on scripted readings, through the very layers of a real run.

    ``range`` and ``camera`` script the first device of their kind, ``readings`` any sensor by its name. ``robot`` is
    a description, or the name or file of one. Only what the app needs is opened, as in a real run.

    >>> from drivers.mock import MockRobot
    >>> robot = MockRobot(range=[1.0, 0.2])
    >>> robot.robot.range.read().distance
    1.0
    """

    def __init__(
        self,
        robot: str | RobotDescription = "rover",
        *,
        range: Script | None = None,  # noqa: A002  the role's name
        camera: Script | None = None,
        readings: Mapping[str, Script] | None = None,
        rate_hz: float = 20.0,
    ) -> None:
        self.description = load_robot(robot) if isinstance(robot, str) else robot
        self.rate_hz = rate_hz
        self.ticks: list[TickRecord] = []
        self.wheels: list[Wheels] = []
        self._scripts = dict(readings or {})
        self._add_script(RangeSensorDescription, range)
        self._add_script(CameraDescription, camera)
        self._raw: Robot | None = None
        self._assembled: Assembled | None = None
        self._loop: Loop | None = None

    def run(self, app: Behaviour, ticks: int = 1) -> Status:
        """Let the app decide ``ticks`` times, or until it is done; return what it said last.

        Keeps each tick in ``ticks``, and in ``wheels`` what the wheels were told by its end. Raises what ends a
        real run: SafetyStop, DeviceError, BehaviourError.
        """
        assembled = self._open_for(app)
        loop = Loop(assembled, app, self.rate_hz, math.inf, [self._keep])
        status = Status.RUNNING
        for _ in range(ticks):
            status = loop.tick()
            if status is not Status.RUNNING:
                break
            self._begin_tick(assembled)
        return status

    @property
    def robot(self) -> Robot:
        """The robot as an app sees it; with every device open, where no app has been run yet."""
        return self._assembled_with(frozenset(device.name for device in self.description.devices)).robot

    def advance(self, ticks: int = 1) -> None:
        """Let time pass without a decision, as a stalled app would."""
        assembled = self._assembled_with(frozenset(device.name for device in self.description.devices))
        for _ in range(ticks):
            self._begin_tick(assembled)

    @property
    def pictures(self) -> list[Image]:
        """What the displays were shown, in their order."""
        return [picture for device in self._devices(MockDisplay) for picture in device.pictures]

    @property
    def commands(self) -> dict[str, list[Command]]:
        """What each motor was told, and when: clamped, guarded, and stopped by the deadman."""
        return {motor.name: motor.commands for motor in self._devices(MockMotor)}

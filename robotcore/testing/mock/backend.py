"""The mock backend, which opens mock devices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from robotcore.description import RobotDescription, StrictModel
from robotcore.errors import UnknownNameError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.kind import list_monitored, load_kind
from robotcore.hal.robot import Robot
from robotcore.testing.mock.devices import MockActuator, MockMotor, Readings, Script, open_actuator, open_sensor


class MockOptions(StrictModel):
    """The options of the mock backend. It has none."""


class MockBackend(Backend):
    """A backend whose sensors of any kind return scripted readings, and whose actuators record their commands.

    Without a script, a sensor returns the reading that its kind has without one: a range sensor inf, a camera a grey
    picture, a bumper False, other sensors 0. An encoder of the drive returns the angle of a wheel that turns as
    commanded. A battery without a script is not opened.

    scripts: the script of each sensor, by the sensor's name.
    """

    name = "mock"
    summary = "scripted readings, recorded commands; no physics"
    capabilities = frozenset({Capability.LOCKSTEP})

    def __init__(self, scripts: Mapping[str, Script] | None = None) -> None:
        self._scripts = dict(scripts or {})

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of all devices but monitored sensors, such as a battery, without a script."""
        return frozenset(device.name for device in robot.devices) - (list_monitored(robot) - self._scripts.keys())

    def check_scripts(self, robot: RobotDescription) -> None:
        """Raise UsageError for a script of an unknown sensor, and for a wrong reading in a script that is a list."""
        sensors = {each.name: each for each in robot.devices if load_kind(each.kind).sample}
        for name, script in self._scripts.items():
            if name not in sensors:
                raise UnknownNameError("scripted sensor", name, list(sensors))
            Readings(sensors[name]).check(script)

    def open(self, setup: Setup) -> Robot:
        setup.options_as(MockOptions)
        self.check_scripts(setup.robot)
        clock = SteppedClock(setup.rate_hz, lambda _steps: None)
        return Robot(setup.robot.name, clock, self._devices(setup, clock))

    def _devices(self, setup: Setup, clock: Clock) -> Iterator[Device]:
        openable, drive = self.openable(setup.robot, setup.options), setup.robot.drive
        chosen = [each for each in setup.chosen_devices if each.name in openable]
        actuators = {each.name: open_actuator(each, clock) for each in chosen if not load_kind(each.kind).sample}
        for each in chosen:
            if each.name in actuators:
                yield actuators[each.name]
            else:
                motor = actuators.get(drive.motor_by_device.get(each.name, "")) if drive else None
                script = self._scripts.get(each.name, _make_wheel_script(motor))
                yield open_sensor(each, script, clock, setup.rate_hz)


def _make_wheel_script(motor: MockActuator | None) -> Script | None:
    return (lambda _time: motor.angle) if isinstance(motor, MockMotor) else None

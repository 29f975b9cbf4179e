"""The mock backend, which opens mock devices."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from robotcore.description import Drive, RobotDescription, StrictModel
from robotcore.errors import UnknownNameError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.kind import list_monitored
from robotcore.hal.robot import Robot
from robotcore.kinds.battery import BatteryDescription
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.testing.mock.devices import (
    MockBattery,
    MockCamera,
    MockDisplay,
    MockEncoder,
    MockMotor,
    MockRangeSensor,
    Script,
    grey_picture,
)


class MockOptions(StrictModel):
    """The options of the mock backend. It has none."""


class MockBackend(Backend):
    """A backend whose sensors return scripted readings.

    Without a script, a range sensor returns inf, a camera returns a grey picture, and an encoder returns the angle of a
    wheel that turns as commanded. A battery without a script is not opened.

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

    def open(self, setup: Setup) -> Robot:
        setup.options_as(MockOptions)
        self._require_known(setup)
        clock = SteppedClock(setup.rate_hz, lambda _steps: None)
        return Robot(setup.robot.name, clock, self._devices(setup, clock))

    def _require_known(self, setup: Setup) -> None:
        sensors = [d.name for d in setup.robot.devices if d.kind not in ("motor", "display")]
        for name in self._scripts:
            if name not in sensors:
                raise UnknownNameError("scripted sensor", name, sensors)

    def _devices(self, setup: Setup, clock: Clock) -> Iterator[Device]:
        rate_hz, scripts = setup.rate_hz, self._scripts
        motors = {d.name: MockMotor(d, clock) for d in setup.chosen_devices if isinstance(d, MotorDescription)}
        for device in setup.chosen_devices:
            name = device.name
            if isinstance(device, MotorDescription):
                yield motors[name]
            elif isinstance(device, RangeSensorDescription):
                yield MockRangeSensor(device, scripts.get(name, math.inf), clock, rate_hz)
            elif isinstance(device, CameraDescription):
                script = scripts.get(name, grey_picture(device.intrinsics))
                yield MockCamera(device, script, clock, rate_hz)
            elif isinstance(device, EncoderDescription):
                script = scripts.get(name, _make_wheel_script(motors.get(_find_motor(name, setup.robot.drive))))
                yield MockEncoder(name, script, clock, rate_hz)
            elif isinstance(device, BatteryDescription):
                if name in scripts:
                    yield MockBattery(name, scripts[name], clock, rate_hz)
            else:
                yield MockDisplay(name)


def _find_motor(encoder: str, drive: Drive | None) -> str:
    return drive.wheel_motors.get(encoder, "") if drive else ""


def _make_wheel_script(motor: MockMotor | None) -> Script:
    return (lambda _time: motor.angle) if motor else 0.0

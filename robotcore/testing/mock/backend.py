"""The mock backend: opens any robot with devices that follow a script."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from robotcore.description import (
    BatteryDescription,
    CameraDescription,
    DisplayDescription,
    Drive,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    StrictModel,
)
from robotcore.errors import UnknownNameError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.devices import Device
from robotcore.hal.robot import Robot
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
    """The command line's mock takes no options: nothing in range, a grey picture, wheels that turn as told."""


class MockBackend(Backend):
    """Opens a robot whose sensors play ``scripts``, by device name.

    The others read nothing in range, a grey picture, and the angle of a wheel that turns as it is told; a battery
    without a script is not there.
    """

    name = "mock"
    summary = "scripted readings, commands kept for assertions; no physics"
    capabilities = frozenset({Capability.LOCKSTEP})

    def __init__(self, scripts: Mapping[str, Script] | None = None) -> None:
        self._scripts = dict(scripts or {})

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return frozenset(battery.name for battery in robot.all_of(BatteryDescription) if battery.name in self._scripts)

    def open(self, setup: Setup) -> Robot:
        setup.options_as(MockOptions)
        self._require_known(setup)
        clock = SteppedClock(setup.rate_hz, lambda _steps: None)
        return Robot(setup.robot.name, clock, self._devices(setup, clock))

    def _require_known(self, setup: Setup) -> None:
        sensors = [d.name for d in setup.robot.devices if d.kind not in ("motor", "display")]
        for name in self._scripts:
            if name not in sensors:
                raise UnknownNameError("sensor in a script", name, sensors)

    def _devices(self, setup: Setup, clock: Clock) -> Iterator[Device]:
        rate_hz, scripts = setup.rate_hz, self._scripts
        motors = {d.name: MockMotor(d, clock) for d in setup.chosen if isinstance(d, MotorDescription)}
        for device in setup.chosen:
            name = device.name
            if isinstance(device, MotorDescription):
                yield motors[name]
            elif isinstance(device, RangeSensorDescription):
                yield MockRangeSensor(device, scripts.get(name, math.inf), clock, rate_hz)
            elif isinstance(device, CameraDescription):
                script = scripts.get(name, grey_picture(device.intrinsics))
                yield MockCamera(device, script, clock, rate_hz)
            elif isinstance(device, EncoderDescription):
                script = scripts.get(name, _script_of_wheel(motors.get(_motor_of(name, setup.robot.drive))))
                yield MockEncoder(name, script, clock, rate_hz)
            elif isinstance(device, BatteryDescription):
                if name in scripts:
                    yield MockBattery(name, scripts[name], clock, rate_hz)
            else:
                display: DisplayDescription = device  # of a new kind of device, the type checker tells
                yield MockDisplay(display.name)


def _motor_of(encoder: str, drive: Drive | None) -> str:
    """Return the name of the motor whose wheel an encoder counts, or nothing."""
    return drive.wheel_motors.get(encoder, "") if drive else ""


def _script_of_wheel(motor: MockMotor | None) -> Script:
    return (lambda _time: motor.angle) if motor else 0.0

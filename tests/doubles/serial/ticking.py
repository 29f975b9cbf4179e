"""The conformance kit on boards whose own time-out cannot be set: it commands as an app does, in every tick."""

from __future__ import annotations

from contextlib import suppress

from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.devices import Motor
from robotcore.hal.robot import Robot
from robotcore.testing.bench import RATE_HZ
from robotcore.testing.spies import MotorSpy
from tests.doubles.serial.bench import SerialBench


class TickingBench(SerialBench):
    """What a motor was told last it is told again in the next tick; the kit tells it once, and lets seconds pass."""

    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        told = {device: MotorSpy(device) for device in robot.devices.values() if isinstance(device, Motor)}

        def tick() -> None:
            for motor, spy in told.items():
                if abs(spy.last) > 0:  # nothing was told where it is NaN
                    with suppress(DeviceError):  # the kit has cut its wire
                        motor.set_velocity(spy.last)

        robot.clock.every(1 / RATE_HZ, tick, "the app's ticks")
        return robot

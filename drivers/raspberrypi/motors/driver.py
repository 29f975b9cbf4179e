"""What the drivers of motors on pins have in common: settings, what is refused, and how another process stops them."""

from __future__ import annotations

import os
from abc import abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Annotated, Generic, TypeVar

from pydantic import Field

from drivers.raspberrypi.gpio import Gpio
from drivers.raspberrypi.motors.model import MotorModel
from drivers.raspberrypi.motors.motor import Bridge, PinMotor
from robotcore.description import Described, MotorDescription, RobotDescription
from robotcore.devices import Motor
from robotcore.guardian import CutoffSpec
from robotcore.hardware import DeviceDriver, Host


class MotorSettings(Described):
    """A motor's model, the frequency of its PWM, and the line that puts its board to sleep, where there is one.

    ``standby`` (TB6612: STBY, DRV8833: nSLEEP) may be shared by motors. No driver claims it: the guardian process holds
    it high while it watches, so that the motors stand when this process is gone, whatever became of its own lines.
    """

    standby: Gpio | None = None
    frequency_hz: Annotated[int, Field(ge=10, le=10_000)] = 100
    model: MotorModel


SettingsT = TypeVar("SettingsT", bound=MotorSettings)


class MotorDriver(DeviceDriver[MotorDescription, SettingsT], Generic[SettingsT]):
    """Opens a motor on the lines that a subclass knows.

    lgpio, the default library, makes PWM in software and begins a command with the next cycle: one, and a stop too,
    may be late by ``1 / frequency_hz``.
    """

    described = MotorDescription
    modules = ("gpiozero",)
    remedy = "pip install 'robotcore[pi]'"

    @abstractmethod
    def lines(self, settings: SettingsT) -> tuple[int, ...]:
        """Return the GPIOs that have to go low for the motor to stand."""

    @abstractmethod
    def bridge(self, name: str, settings: SettingsT, host: Host, opened: ExitStack) -> Bridge:
        """Open the lines into ``opened``; raises DeviceError."""

    def check(self, told: MotorDescription, settings: SettingsT, robot: RobotDescription) -> None:
        for direction, word in ((1, "forward"), (-1, "backward")):
            if (reach := settings.model.reach(direction)) < told.max_velocity_rad_s:
                raise ValueError(
                    f"the wheel turns {word} at {reach:.3g} rad/s at most, by its model, and max_velocity_rad_s of "
                    f"{told.name} is {told.max_velocity_rad_s:g}; lower that, or correct model.{word}_rad_s or "
                    "model.max_duty"
                )

    def open(self, told: MotorDescription, settings: SettingsT, host: Host) -> Motor:
        with ExitStack() as opened:
            bridge = self.bridge(told.name, settings, host, opened)
            return PinMotor(told, settings.model, bridge, self.lines(settings), opened.pop_all())

    def cutoffs(self, told: MotorDescription, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        from gpiozero.pins.mock import MockFactory

        if isinstance(host.pins, MockFactory):  # nobody else sees these pins
            return ()
        if settings.standby is not None:
            return (CutoffSpec(told.name, "drivers.raspberrypi.cutoff:StandbyLine", {"line": settings.standby}),)
        lines = {"lines": list(self.lines(settings)), "owner": os.getpid()}
        return (CutoffSpec(told.name, "drivers.raspberrypi.cutoff:MotorLines", lines),)

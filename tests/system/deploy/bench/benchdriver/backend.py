"""The backend of the bench: motors without hardware, and the machine's own clock."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.motor import Motor, MotorDescription

from .cutoff import write_command


class BenchMotor(Motor):
    """Writes each command into the log."""

    def _apply(self, rad_s: float) -> None:
        write_command("app", self.name, rad_s)


class BenchBackend(Backend):
    """Opens the motors of any robot. They turn until a command of 0, as real motor lines keep their level."""

    name = "bench"
    summary = "motors that write their commands into a log"

    def open(self, setup: Setup) -> Robot:
        motors = [BenchMotor(device.name, device.max_velocity_rad_s) for device in _motors(setup)]
        return Robot(setup.robot.name, MonotonicClock(), motors, cutoffs=self.cutoffs(setup))

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        cutoff = "benchdriver.cutoff:LoggedCutoff"
        return [CutoffSpec(device.name, cutoff, {"motor": device.name}) for device in _motors(setup)]


def _motors(setup: Setup) -> Iterable[MotorDescription]:
    return (device for device in setup.chosen_devices if isinstance(device, MotorDescription))

"""The bench as a backend: its time is the machine's own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from robotcore.description import MotorDescription
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Motor
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock

from .diary import note


class BenchMotor(Motor):
    """Writes down what it is told."""

    def _apply(self, rad_s: float) -> None:
        note("app", self.name, rad_s)


class BenchBackend(Backend):
    """Opens the motors of any robot; they keep turning until somebody stops them, as lines that keep their level do."""

    name = "bench"
    summary = "motors that write down what they are told"

    def open(self, setup: Setup) -> Robot:
        motors = [BenchMotor(device.name, device.max_velocity_rad_s) for device in _motors(setup)]
        return Robot(setup.robot.name, MonotonicClock(), motors, cutoffs=self.cutoffs(setup))

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        cutoff = "benchdriver.cutoff:Written"
        return [CutoffSpec(device.name, cutoff, {"motor": device.name}) for device in _motors(setup)]


def _motors(setup: Setup) -> Iterable[MotorDescription]:
    return (device for device in setup.chosen if isinstance(device, MotorDescription))

"""A robot in real time whose motors write each command, with its time, to a log file."""

from __future__ import annotations

import os
from time import monotonic

import numpy as np

from robotcore.description import (
    AnyDevice,
    CameraDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    StrictModel,
)
from robotcore.errors import DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import Cutoff, CutoffSpec
from robotcore.hal.devices import Angle, Camera, Device, Encoder, Frame, MemoryDisplay, Motor, Range, RangeSensor
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock

FAR_M = 1.5


class LoggingOptions(StrictModel):
    """The options: the log file, the time at which the camera fails, and whether the robot has a guardian."""

    log: str
    lost_after_s: float = float("inf")
    is_guarded: bool = False


class Log:
    """A log file. Each line has an event, a value and the machine's monotonic time."""

    def __init__(self, file: str) -> None:
        self._file = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT)

    def write(self, event: str, value: float = 0.0) -> None:
        os.write(self._file, f"{event} {value} {monotonic():.6f}\n".encode())


class LoggingBackend(Backend):
    """Opens robots whose motors log their commands, and whose sensors return constants."""

    name = "logging"
    summary = "logs every command, in real time"

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(LoggingOptions)
        clock, log = MonotonicClock(), Log(options.log)
        devices = [_open_device(description, clock, log, options.lost_after_s) for description in setup.chosen_devices]
        cutoffs = [_build_cutoff(device.name, options.log) for device in devices if isinstance(device, Motor)]
        return Robot(setup.robot.name, clock, devices, cutoffs=cutoffs if options.is_guarded else ())


class LoggingCutoff(Cutoff):
    """A cutoff that logs a stop like the motor of the same name."""

    def __init__(self, device: str, log: str) -> None:
        self._device, self._log = device, Log(log)

    def open(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        self._log.write(self._device)

    def close(self) -> None:
        """Do nothing."""


class LoggingMotor(Motor):
    """A motor that logs each command."""

    def __init__(self, description: MotorDescription, log: Log) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._log = log

    def _apply(self, rad_s: float) -> None:
        self._log.write(self.name, rad_s)


class LoggingRange(RangeSensor):
    """A range sensor that always measures 1.5 m."""

    def __init__(self, descriptions: RangeSensorDescription, clock: Clock) -> None:
        super().__init__(
            descriptions.name,
            min_range=descriptions.min_range_m,
            max_range=descriptions.max_range_m,
            cone=descriptions.cone_rad,
        )
        self._clock = clock

    def _newest(self) -> Range:
        return Range(FAR_M, self._clock.now(), 0)


class LoggingCamera(Camera):
    """A camera with black pictures. It fails after a time, and logs the failure."""

    def __init__(self, description: CameraDescription, clock: Clock, log: Log, lost_after_s: float) -> None:
        super().__init__(description.name, description.intrinsics)
        self._clock, self._log, self._lost_after_s = clock, log, lost_after_s
        self._image = np.zeros((description.height_px, description.width_px, 3), np.uint8)
        self._image.flags.writeable = False

    def _newest(self) -> Frame:
        now = self._clock.now()
        if now > self._lost_after_s:
            self._log.write("event")
            raise DeviceError(self.name, "the cable is out")
        return Frame(self._image, now, 0)


class LoggingEncoder(Encoder):
    """An encoder that always measures zero."""

    def __init__(self, description: EncoderDescription, clock: Clock) -> None:
        super().__init__(description.name)
        self._clock = clock

    def _newest(self) -> Angle:
        return Angle(0.0, self._clock.now(), 0)


def _build_cutoff(device: str, log: str) -> CutoffSpec:
    return CutoffSpec(device, f"{__name__}:LoggingCutoff", {"device": device, "log": log})


def _open_device(description: AnyDevice, clock: Clock, log: Log, lost_after_s: float) -> Device:
    match description:
        case MotorDescription():
            return LoggingMotor(description, log)
        case RangeSensorDescription():
            return LoggingRange(description, clock)
        case CameraDescription():
            return LoggingCamera(description, clock, log, lost_after_s)
        case EncoderDescription():
            return LoggingEncoder(description, clock)
    return MemoryDisplay(description.name)

"""A robot of `benchmarks.run_endings`, in real time. Its motors note each command in a diary."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robotcore.description import StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.clock import Clock
from robotcore.hal.device import Device
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.camera import Camera, CameraDescription, Frame
from robotcore.kinds.display import MemoryDisplay
from robotcore.kinds.encoder import Angle, Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription
from tests.robotcore.safety.guardian.doubles import RecordingMotor, cutoff
from tests.robotcore.safety.guardian.recorder import Diary


class LoggingOptions(StrictModel):
    """The options: the diary, the time at which the camera fails, and whether the robot has a guardian."""

    diary: str
    lost_after_s: float = float("inf")
    is_guarded: bool = False


class LoggingBackend(Backend):
    """Opens robots whose motors note their commands, and whose sensors return constants."""

    name = "logging"
    summary = "notes every command, in real time"

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(LoggingOptions)
        clock, diary = MonotonicClock(), Diary(options.diary)
        devices: list[Device] = []
        for description in setup.chosen_devices:
            match description:
                case MotorDescription():
                    devices.append(RecordingMotor(description.name, diary))
                case CameraDescription():
                    devices.append(BlackCamera(description, clock, diary, options.lost_after_s))
                case EncoderDescription():
                    devices.append(ConstantEncoder(description.name, clock))
                case _:
                    devices.append(MemoryDisplay(description.name))
        motors = [device.name for device in devices if isinstance(device, Motor) and options.is_guarded]
        cutoffs = [cutoff(Path(options.diary), name) for name in motors]
        return Robot(setup.robot.name, clock, devices, cutoffs=cutoffs)


class BlackCamera(Camera):
    """A camera with black pictures. It fails after a time, and notes the failure."""

    def __init__(self, description: CameraDescription, clock: Clock, diary: Diary, lost_after_s: float) -> None:
        super().__init__(description.name, description.intrinsics)
        self._clock, self._diary, self._lost_after_s = clock, diary, lost_after_s
        self._image = np.zeros((description.height_px, description.width_px, 3), np.uint8)
        self._image.flags.writeable = False

    def _newest(self) -> Frame:
        now = self._clock.now()
        if now > self._lost_after_s:
            self._diary.note("event")
            raise DeviceError(self.name, "the cable is out")
        return Frame(self._image, now, 0)


class ConstantEncoder(Encoder):
    """An encoder that always measures zero."""

    def __init__(self, name: str, clock: Clock) -> None:
        super().__init__(name)
        self._clock = clock

    def _newest(self) -> Angle:
        return Angle(0.0, self._clock.now(), 0)

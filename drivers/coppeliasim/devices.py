"""The devices of a robot that was built: nothing is asked of the simulator unless it is needed."""

from __future__ import annotations

import math

import cv2
import numpy as np

from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.clock import Clock
from robotcore.description import CameraDescription, DisplayDescription, EncoderDescription, MotorDescription
from robotcore.devices import Angle, Camera, Display, Encoder, Frame, Image, Motor
from robotcore.sampling import OnceAnInstant
from robotcore.scene import RawPicture


class BuiltMotor(Motor):
    """A joint, told a velocity that lags behind the one asked for.

    A step h of the simulator's may be as long as the lag τ, so it is told the mean of what the lag lets through in it:
    what is missing, times 1 - τ/h·(1 - exp(-h/τ)).
    """

    def __init__(self, scene: CoppeliaSimScene, description: MotorDescription, joint: int, step: float) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._scene, self._joint = scene, joint
        lag = description.lag_s
        self._through = -math.expm1(-step / lag) if lag else 1.0
        self._mean = 1 - lag / step * self._through
        self._asked = self._velocity = self._sent = 0.0

    def drive(self) -> None:
        """Tell the joint how it turns in the step that comes."""
        missing = self._asked - self._velocity
        self._send(self._velocity + missing * self._mean)
        self._velocity += missing * self._through

    def _apply(self, rad_s: float) -> None:
        self._asked = rad_s

    def _send(self, rad_s: float) -> None:
        if rad_s != self._sent:
            self._scene.set_joint_velocity(self._joint, rad_s)
            self._sent = rad_s


class BuiltEncoder(Encoder):
    """Whole counts of a wheel's joint."""

    def __init__(self, scene: CoppeliaSimScene, description: EncoderDescription, joint: int, clock: Clock) -> None:
        super().__init__(description.name)
        self._scene, self._description, self._joint = scene, description, joint
        self._turned = _Turned(scene.joint_position(joint))
        self._newest_at = OnceAnInstant(clock, self._count)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        angle = self._turned.to(self._scene.joint_position(self._joint))
        return Angle(self._description.quantised(angle), time, sequence)


class _Turned:
    """Adds a joint's angle up, which may be told in (-π, π]."""

    def __init__(self, angle: float) -> None:
        self._last, self._sum = angle, 0.0

    def to(self, angle: float) -> float:
        self._sum += math.remainder(angle - self._last, math.tau)
        self._last = angle
        return self._sum


class BuiltCamera(Camera):
    """A vision sensor, rendered when it is read."""

    def __init__(self, scene: CoppeliaSimScene, description: CameraDescription, sensor: int, clock: Clock) -> None:
        super().__init__(description.name, description.intrinsics)
        self._scene, self._sensor = scene, sensor
        self._newest_at = OnceAnInstant(clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        return Frame(upright(self._scene.picture(self._sensor)), time, sequence)


class BuiltDisplay(Display):
    """A vision sensor that shows what it is given, at its own size."""

    def __init__(
        self, scene: CoppeliaSimScene, description: DisplayDescription, sensor: int, size: tuple[int, int]
    ) -> None:
        super().__init__(description.name)
        self._scene, self._sensor, self._size = scene, sensor, size

    def _show(self, image: Image) -> None:
        colour = cv2.cvtColor(image, cv2.COLOR_GRAY2RGB if image.ndim == 2 else cv2.COLOR_BGR2RGB)
        if colour.shape[1::-1] != self._size:
            colour = cv2.resize(colour, self._size, interpolation=cv2.INTER_AREA)
        self._scene.show(self._sensor, RawPicture(cv2.flip(colour, 0).tobytes(), *self._size))


def upright(raw: RawPicture) -> Image:
    """Return a simulator's pixels as a picture: BGR, top-left origin, read-only."""
    pixels = np.frombuffer(raw.pixels, dtype=np.uint8).reshape(raw.height, raw.width, 3)
    image: Image = np.asarray(cv2.cvtColor(cv2.flip(pixels, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)
    image.flags.writeable = False
    return image

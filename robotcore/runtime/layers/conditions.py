"""Simulated devices as the world's conditions have them; where those are perfect, as they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from robotcore.description import Conditions, Drive
from robotcore.hal.devices import Camera, Frame, Image, Motor, Range, RangeSensor
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.noise import Noise
from robotcore.runtime.layers.over import MotorOver, reading_of
from robotcore.runtime.layers.readers import Reader

PERFECT = Conditions()

Effect = Callable[[Image, float], Image]
"""Makes of a picture, and of the time it was captured at, another picture."""


class Conditioned(Layer):
    """Every device as the conditions have it; their noise belongs to the ``seed``, their gains to the ``drive``."""

    def __init__(self, conditions: Conditions, seed: int, drive: Drive | None) -> None:
        self._conditions, self._seed = conditions, seed
        wheels = (drive.left, drive.right) if drive else ()
        self._gains = dict(zip(wheels, (conditions.wheel_gain_left, conditions.wheel_gain_right), strict=False))

    def camera(self, camera: Camera, read: Reader[Frame]) -> Reader[Frame]:
        noise = Noise(self._seed, camera.name, self._conditions.camera_noise)
        effects = list(_effects(self._conditions, noise))
        return Developed(read, effects) if effects else read

    def range_sensor(self, sensor: RangeSensor, read: Reader[Range]) -> Reader[Range]:
        """Return what reads the range sensor: off by a bias and by noise."""
        bias, sigma = self._conditions.range_bias_m, self._conditions.range_noise_m
        return Erring(sensor, read, bias, Noise(self._seed, sensor.name, sigma)) if bias or sigma else read

    def motor(self, motor: Motor) -> Motor:
        """Return the motor, whose wheel turns its gain times as fast as it is told."""
        gain = self._gains.get(motor.name, 1.0)
        return motor if gain == 1.0 else GainedMotor(motor, gain)


class Developed:
    """Frames after some effects, one after the other; their time and number stay."""

    def __init__(self, read: Reader[Frame], effects: Sequence[Effect]) -> None:
        self._read, self._effects = read, effects

    def __call__(self) -> Frame:
        frame = self._read()
        image = frame.image
        for effect in self._effects:
            image = effect(image, frame.time)
        image.flags.writeable = False
        return Frame(image, frame.time, frame.sequence)


class Erring:
    """Distances that are off: never nearer than the sensor can tell; past its range, and where nothing is, ``inf``."""

    def __init__(self, sensor: RangeSensor, read: Reader[Range], bias: float, noise: Noise) -> None:
        self._sensor, self._read, self._bias, self._noise = sensor, read, bias, noise

    def __call__(self) -> Range:
        reading = self._read()
        return reading_of(self._sensor, reading, reading.distance + self._bias + self._noise.at(reading.time))


class GainedMotor(MotorOver):
    """A motor that turns its gain times as fast as it is told, up to its limit, and does not know."""

    def __init__(self, inner: Motor, gain: float) -> None:
        super().__init__(inner)
        self._gain = gain

    def _apply(self, rad_s: float) -> None:
        self._inner.set_velocity(self._gain * rad_s)


def _effects(conditions: Conditions, noise: Noise) -> Iterator[Effect]:
    """Yield what happens to a picture, in the order in which light goes: through the lens, into the sensor, out."""
    if conditions.camera_blur_px:
        yield _blur(conditions.camera_blur_px)
    if (conditions.camera_exposure, conditions.camera_warmth) != (1.0, 0.0):
        yield _response(conditions)
    if conditions.camera_noise:
        yield grain(noise)


def _blur(sigma: float) -> Effect:
    import cv2

    return lambda image, _time: np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), dtype=np.uint8)


def _response(conditions: Conditions) -> Effect:
    """Return what answers to light by a table: blue and red against each other, and no more than white."""
    import cv2

    warmth = conditions.camera_warmth
    gains = conditions.camera_exposure * np.array((1 - warmth, 1.0, 1 + warmth))
    table = np.minimum(np.rint(np.arange(256)[None, :, None] * gains), 255).astype(np.uint8)
    return lambda image, _time: np.asarray(cv2.LUT(image, table), dtype=np.uint8)


def grain(noise: Noise) -> Effect:
    """Return what adds noise to a picture; it ends at black and at white."""
    import cv2

    def grainy(image: Image, time: float) -> Image:
        return np.asarray(cv2.add(image, noise.over(image.shape, time), dtype=cv2.CV_8U), dtype=np.uint8)

    return grainy

"""The layer that simulates the imperfections of a world: sensor noise, sensor bias, blur, and velocity errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from robotcore.description import Conditions, Drive
from robotcore.hal.device import Sensor
from robotcore.hal.noise import Noise, build_noise_effect
from robotcore.kinds.camera import Camera, Frame
from robotcore.optics import Image
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader

PERFECT = Conditions()

Effect = Callable[[Image, float], Image]
"""A function that returns a changed picture. Its arguments are a picture and the time of capture in seconds."""


class ImperfectionLayer(Layer):
    """Applies the conditions of a world to every device.

    conditions: the noise, bias and blur of sensors, and the gain of each wheel. A motor of wheels on both sides has the
        mean of both gains.
    seed: the seed of the noise.
    drive: the description of the drive, which names the motors of the wheels.
    """

    def __init__(self, conditions: Conditions, seed: int, drive: Drive | None) -> None:
        self._conditions, self._seed = conditions, seed
        left, right = (drive.left_motors, drive.right_motors) if drive else ((), ())
        gain_left, gain_right = conditions.wheel_gain_left, conditions.wheel_gain_right
        self._gains = dict.fromkeys(left, gain_left) | dict.fromkeys(right, gain_right)
        self._gains |= dict.fromkeys(set(left) & set(right), (gain_left + gain_right) / 2)

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        if isinstance(sensor, Camera):
            noise = Noise(self._seed, sensor.name, self._conditions.camera_noise)
            effects = list(_effects(self._conditions, noise))
            return ProcessedFrames(read, effects) if effects else read
        bias, sigma = self._conditions.range_bias_m, self._conditions.range_noise_m
        if sensor.has_rays and (bias or sigma):

            def disturb(time: float, distance: float, ray: int) -> float:
                noise = Noise(self._seed, f"{sensor.name}[{ray}]" if ray else sensor.name, sigma)
                return distance + bias + noise.draw_number(time)

            def read_noisily() -> Any:
                sample = read()
                return sensor.change_distances(sample, partial(disturb, sample.time))

            return read_noisily
        return read

    def motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that multiplies each velocity by the wheel's gain.

        The output returns the velocity without the gain, because a real motor does not report its error.
        """
        gain = self._gains.get(motor.name, 1.0)
        if gain == 1.0:
            return motor

        def set_velocity(rad_s: float) -> float:
            motor.set_velocity(gain * rad_s)
            return rad_s

        return replace(motor, set_velocity=set_velocity)


class ProcessedFrames:
    """Reads a camera and applies the effects to each picture in their order."""

    def __init__(self, read: Reader[Frame], effects: Sequence[Effect]) -> None:
        self._read, self._effects = read, effects

    def __call__(self) -> Frame:
        frame = self._read()
        image = frame.image
        for effect in self._effects:
            image = effect(image, frame.time)
        image.flags.writeable = False
        return Frame(image, frame.time, frame.sequence)


def _effects(conditions: Conditions, noise: Noise) -> Iterator[Effect]:
    """Yield the effects in the order of a camera: lens (blur), sensor (exposure and warmth), output (noise)."""
    if conditions.camera_blur_px:
        yield _blur(conditions.camera_blur_px)
    if (conditions.camera_exposure, conditions.camera_warmth) != (1.0, 0.0):
        yield _response(conditions)
    if conditions.camera_noise:
        yield build_noise_effect(noise)


def _blur(sigma: float) -> Effect:
    import cv2

    return lambda image, _time: np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), dtype=np.uint8)


def _response(conditions: Conditions) -> Effect:
    import cv2

    warmth = conditions.camera_warmth
    gains = conditions.camera_exposure * np.array((1 - warmth, 1.0, 1 + warmth))
    table = np.minimum(np.rint(np.arange(256)[None, :, None] * gains), 255).astype(np.uint8)
    return lambda image, _time: np.asarray(cv2.LUT(image, table), dtype=np.uint8)

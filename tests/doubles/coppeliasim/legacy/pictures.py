"""Answers about vision sensors: images in grey and colour, read and set."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.functions import Functions
from tests.doubles.coppeliasim.legacy.objects import INT, handle
from tests.doubles.coppeliasim.legacy.refused import Answers, RefusedError, refusing

RESOLUTION = struct.Struct("<2i")


def answers_on_pictures(functions: Functions) -> Answers:
    """Return what can be asked of the vision sensors of a scene."""
    pictures = Pictures(functions)
    return {
        Code.GET_VISION_SENSOR_IMAGE_BW: pictures.grey,
        Code.GET_VISION_SENSOR_IMAGE_RGB: pictures.colour,
        Code.SET_VISION_SENSOR_IMAGE_BW: pictures.set_grey,
        Code.SET_VISION_SENSOR_IMAGE_RGB: pictures.set_colour,
        Code.READ_VISION_SENSOR: pictures.read,
    }


class Pictures:
    """The commands that name a vision sensor: width and height, then the pixels, the lowest row first."""

    def __init__(self, functions: Functions) -> None:
        self._functions = functions

    def colour(self, command: Command) -> bytes:
        return _packed(self._image(command))

    def grey(self, command: Command) -> bytes:
        """Return the mean of the three colours, rounded down, as the server's plug-in does."""
        image = self._image(command)
        return _packed((image.sum(axis=2, dtype=np.uint16) // 3).astype(np.uint8))

    def set_colour(self, command: Command) -> bytes:
        return self._set(command, channels=3)

    def set_grey(self, command: Command) -> bytes:
        return self._set(command, channels=1)

    def read(self, command: Command) -> bytes:
        """Refuse without a text, as the real one does while stopped; what it tells in a run is not on record."""
        self._image(command)
        raise RefusedError(None, INT.pack(0))

    def _image(self, command: Command) -> NDArray[np.uint8]:
        with refusing("simGetVisionSensorResolution"):
            return self._functions.picture(handle(command))

    def _set(self, command: Command, channels: int) -> bytes:
        with refusing("simGetVisionSensorResolution"):
            rows, columns = self._functions.resolution(handle(command))
        if len(command.data) != rows * columns * channels:
            raise RefusedError
        pixels = np.frombuffer(command.data, np.uint8).reshape(rows, columns, channels)
        with refusing("simSetVisionSensorCharImage"):
            self._functions.show(handle(command), np.broadcast_to(pixels, (rows, columns, 3)))
        return b""


def _packed(image: NDArray[np.uint8]) -> bytes:
    return RESOLUTION.pack(image.shape[1], image.shape[0]) + image.tobytes()

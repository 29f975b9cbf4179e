"""Sensors, in the official binding's words."""
# ruff: noqa: N802, N803  the official binding's names

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.vrep.simx.clients import read, send
from drivers.vrep.wire import requests
from drivers.vrep.wire.requests import of_handle
from drivers.vrep.wire.values import Pixels, Proximity, read_depth

GREY = 1
_SIGNED = np.arange(256).astype(np.int8).astype(object)
"""The numbers that bytes are with a sign: a list of a quarter of a million is made of these, and not each anew."""

_NOTHING = Proximity(is_detected=False, point=(0.0, 0.0, 0.0), handle=0, normal=(0.0, 0.0, 0.0))


def simxReadProximitySensor(
    clientID: int, sensorHandle: int, operationMode: int
) -> tuple[int, bool, list[float], int, list[float]]:
    """Return the code, whether something is detected, and its point, handle and normal: rubbish if nothing is."""
    code, seen = read(clientID, requests.proximity(sensorHandle), operationMode, _NOTHING)
    return code, seen.is_detected, list(seen.point), seen.handle, list(seen.normal)


def simxGetVisionSensorImage(
    clientID: int, sensorHandle: int, options: int, operationMode: int
) -> tuple[int, list[int], list[int]]:
    """Return the code, [width, height] and signed bytes: RGB, or grey with option 1; the lowest row first."""
    request = (requests.grey_image if options & GREY else requests.colour_image)(sensorHandle)
    code, image = read(clientID, request, operationMode, None)
    return (code, [], []) if image is None else (code, _resolution(image), _signed(image))


def simxSetVisionSensorImage(clientID: int, sensorHandle: int, image: Any, options: int, operationMode: int) -> int:
    """Show an image on a sensor that takes external input; signed or unsigned bytes, in any sequence or array."""
    request = requests.set_grey_image if options & GREY else requests.set_colour_image
    return send(clientID, request(sensorHandle, _bytes_of(image)), operationMode)


def simxGetVisionSensorDepthBuffer(
    clientID: int, sensorHandle: int, operationMode: int
) -> tuple[int, list[int], list[float]]:
    """Return the code, [width, height] and depths: 0 at the near, 1 at the far clipping plane; the lowest row first."""
    request = of_handle("tell the depth of vision sensor", 0x1017, sensorHandle, read_depth)
    code, depth = read(clientID, request, operationMode, None)
    return (code, [], []) if depth is None else (code, _resolution(depth), depth.ravel().tolist())


def simxReadVisionSensor(clientID: int, sensorHandle: int, operationMode: int) -> tuple[int, bool, list[list[float]]]:
    """Return the code, whether its filters have detected something, and the packets of numbers they give."""
    request = of_handle("read vision sensor", 0x1011, sensorHandle, _packets)
    code, (detect, packets) = read(clientID, request, operationMode, (False, []))
    return code, detect, packets


def simxReadForceSensor(
    clientID: int, forceSensorHandle: int, operationMode: int
) -> tuple[int, int, list[float], list[float]]:
    """Return the code, the state (bit 0: has values, bit 1: broken), force in N and torque in N·m."""
    request = of_handle("read force sensor", 0x100F, forceSensorHandle, _force)
    code, (state, force, torque) = read(clientID, request, operationMode, (0, [0.0] * 3, [0.0] * 3))
    return code, state, force, torque


def _resolution(image: npt.NDArray[Any]) -> list[int]:
    height, width = image.shape[:2]
    return [width, height]


def _signed(image: Pixels) -> list[int]:
    values: list[int] = _SIGNED.take(image.ravel(), mode="clip").tolist()  # no index can be wrong; unchecked is faster
    return values


def _bytes_of(image: Any) -> bytes:
    """Return signed or unsigned bytes of any kind as bytes; TypeError for fractions, as the official binding raises."""
    if isinstance(image, (bytes, bytearray, memoryview)):
        return bytes(image)
    values = np.asarray(image)
    if values.dtype.kind not in "iub":
        raise TypeError(f"the values of an image are whole numbers, not {values.dtype}. Turn it into numpy.uint8 first")
    return values.astype(np.uint8).tobytes()


def _packets(data: memoryview) -> tuple[bool, list[list[float]]]:
    detect, count = struct.unpack_from("<Bi", data)
    sizes = struct.unpack_from(f"<{max(count, 0)}i", data, 5)
    return detect != 0, _cut(struct.unpack_from(f"<{sum(sizes)}f", data, 5 + 4 * len(sizes)), sizes)


def _cut(values: Sequence[float], sizes: Sequence[int]) -> list[list[float]]:
    ends = np.cumsum(sizes, dtype=int)
    return [list(values[end - size : end]) for end, size in zip(ends, sizes, strict=True)]


def _force(data: memoryview) -> tuple[int, list[float], list[float]]:
    state, *values = struct.unpack_from("<B6f", data)
    return state, values[:3], values[3:]

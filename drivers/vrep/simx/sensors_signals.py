"""The functions of the official binding about sensors, signals and functions of scripts."""
# ruff: noqa: N802, N803  the names of the official binding

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.vrep.simx import constants as c
from drivers.vrep.simx.clients import CLIENTS, read, send
from drivers.vrep.simx.commands import to_bytes
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import (
    Pixels,
    Proximity,
    floats_reader,
    pack_floats,
    pack_ints,
    pack_text,
    read_depth,
)
from drivers.vrep.wire.requests import Request, build_request

GREY = 1
_SIGNED = np.arange(256).astype(np.int8).astype(object)
"""The signed value of each byte. A look-up in this table is faster than a conversion of each byte of an image."""

_NOTHING = Proximity(is_detected=False, point=(0.0, 0.0, 0.0), handle=0, normal=(0.0, 0.0, 0.0))


def simxGetObjectVelocity(clientID: int, objectHandle: int, operationMode: int) -> tuple[int, list[float], list[float]]:
    """Return the return code, the linear velocity in m/s, and the angular velocity in rad/s, in the world."""
    request = build_request("read the velocity of object", 0x1036, floats_reader(6), objectHandle)
    code, values = read(clientID, request, operationMode, [0.0] * 6)
    return code, values[:3], values[3:]


def simxReadProximitySensor(
    clientID: int, sensorHandle: int, operationMode: int
) -> tuple[int, bool, list[float], int, list[float]]:
    """Return the return code, whether an object is detected, the detected point, the object's handle, and the normal.

    If no object is detected, the last three values are invalid.
    """
    code, reading = read(clientID, requests.proximity(sensorHandle), operationMode, _NOTHING)
    return code, reading.is_detected, list(reading.point), reading.handle, list(reading.normal)


def simxGetVisionSensorImage(
    clientID: int, sensorHandle: int, options: int, operationMode: int
) -> tuple[int, list[int], list[int]]:
    """Return the return code, [width, height], and the signed bytes of an image, the lowest row first.

    options: 0 for RGB, or 1 for grey.
    """
    request = (requests.grey_image if options & GREY else requests.colour_image)(sensorHandle)
    code, image = read(clientID, request, operationMode, None)
    return (code, [], []) if image is None else (code, _get_resolution(image), _to_signed(image))


def simxSetVisionSensorImage(clientID: int, sensorHandle: int, image: Any, options: int, operationMode: int) -> int:
    """Show an image on a vision sensor whose option external input is set, and return the return code.

    image: signed or unsigned bytes in a sequence or an array, the lowest row first.
    options: 0 for RGB, or 1 for grey.
    """
    request = requests.set_grey_image if options & GREY else requests.set_colour_image
    return send(clientID, request(sensorHandle, _image_to_bytes(image)), operationMode)


def simxGetVisionSensorDepthBuffer(
    clientID: int, sensorHandle: int, operationMode: int
) -> tuple[int, list[int], list[float]]:
    """Return the return code, [width, height], and the depths, the lowest row first.

    A depth of 0 is at the near clipping plane, and 1 at the far clipping plane.
    """
    request = build_request("read the depth of vision sensor", 0x1017, read_depth, sensorHandle)
    code, depth = read(clientID, request, operationMode, None)
    return (code, [], []) if depth is None else (code, _get_resolution(depth), depth.ravel().tolist())


def simxReadVisionSensor(clientID: int, sensorHandle: int, operationMode: int) -> tuple[int, bool, list[list[float]]]:
    """Return the return code, whether a filter of the sensor has detected an object, and the numbers of each filter."""
    request = build_request("read vision sensor", 0x1011, _read_packets, sensorHandle)
    code, (detect, packets) = read(clientID, request, operationMode, (False, []))
    return code, detect, packets


def simxReadForceSensor(
    clientID: int, forceSensorHandle: int, operationMode: int
) -> tuple[int, int, list[float], list[float]]:
    """Return the return code, the state, the force in N, and the torque in N·m.

    Bit 0 of the state is set if the sensor has values, and bit 1 if the sensor is broken.
    """
    request = build_request("read force sensor", 0x100F, _read_force, forceSensorHandle)
    code, (state, force, torque) = read(clientID, request, operationMode, (0, [0.0] * 3, [0.0] * 3))
    return code, state, force, torque


def _get_resolution(image: npt.NDArray[Any]) -> list[int]:
    height, width = image.shape[:2]
    return [width, height]


def _to_signed(image: Pixels) -> list[int]:
    values: list[int] = _SIGNED.take(
        image.ravel(), mode="clip"
    ).tolist()  # each index is valid; clip is faster than the check
    return values


def _image_to_bytes(image: Any) -> bytes:
    if isinstance(image, (bytes, bytearray, memoryview)):
        return bytes(image)
    values = np.asarray(image)
    if values.dtype.kind not in "iub":
        raise TypeError(f"an image has integer values, not {values.dtype}. Convert it to numpy.uint8 first")
    return values.astype(np.uint8).tobytes()


def _read_packets(data: memoryview) -> tuple[bool, list[list[float]]]:
    detect, count = struct.unpack_from("<Bi", data)
    sizes = struct.unpack_from(f"<{max(count, 0)}i", data, 5)
    return detect != 0, _split(struct.unpack_from(f"<{sum(sizes)}f", data, 5 + 4 * len(sizes)), sizes)


def _split(values: Sequence[float], sizes: Sequence[int]) -> list[list[float]]:
    ends = np.cumsum(sizes, dtype=int)
    return [list(values[end - size : end]) for end, size in zip(ends, sizes, strict=True)]


def _read_force(data: memoryview) -> tuple[int, list[float], list[float]]:
    state, *values = struct.unpack_from("<B6f", data)
    return state, values[:3], values[3:]


Bytes = str | bytes | bytearray
Results = tuple[list[int], list[float], list[str], bytearray]


def simxGetStringSignal(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, bytearray]:
    """Return the return code and the value of a signal."""
    return read(clientID, build_request("read signal", 0x3012, bytearray, signalName), operationMode, bytearray())


def simxGetAndClearStringSignal(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, bytearray]:
    """Return the return code and the value of a signal, and clear the signal.

    In streaming mode, the server ends the stream after the first value.
    """
    request = build_request("read and clear signal", 0x3017, bytearray, signalName)
    answer = read(clientID, request, operationMode, bytearray())
    if answer[0] == c.simx_return_ok and operationMode == c.simx_opmode_buffer:
        read(clientID, request, c.simx_opmode_remove, bytearray())
    return answer


def simxReadStringStream(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, bytearray]:
    """Return the return code, and the bytes that were appended to a signal since the last call.

    This function never waits. In blocking mode it returns an error code.
    """
    if operationMode == c.simx_opmode_blocking and CLIENTS.get(clientID):
        return c.simx_return_illegal_opmode_flag, bytearray()
    request = build_request("read stream", 0x3018, bytearray, signalName)
    answer = read(clientID, request, operationMode, bytearray())
    if answer[0] == c.simx_return_ok:
        read(clientID, request, c.simx_opmode_remove, bytearray())
    return answer


def simxCallScriptFunction(
    clientID: int,
    scriptDescription: str | bytes,
    options: int,
    functionName: str | bytes,
    inputInts: Sequence[int],
    inputFloats: Sequence[float],
    inputStrings: Sequence[str | bytes],
    inputBuffer: Bytes,
    operationMode: int,
) -> tuple[int, list[int], list[float], list[str], bytearray]:
    """Call a function of a script, and return the return code and the four results of the function."""
    key = pack_ints(options) + pack_text(scriptDescription) + pack_text(functionName)
    buffer = to_bytes(inputBuffer)
    counts = pack_ints(len(inputInts), len(inputFloats), len(inputStrings), len(buffer))
    numbers = pack_ints(*inputInts) + pack_floats(*inputFloats)
    data = counts + numbers + b"".join(map(pack_text, inputStrings)) + buffer
    default: Results = ([], [], [], bytearray())
    call = Request(f"call {functionName!r} of {scriptDescription!r}", 0x3401, key, data, _read_results)
    code, results = read(clientID, call, operationMode, default)
    return code, *results


def simxPackInts(intList: Sequence[int]) -> bytearray:
    """Encode integers as 32-bit integers."""
    return bytearray(pack_ints(*intList))


def simxUnpackInts(intsPackedInString: Bytes) -> list[int]:
    """Decode 32-bit integers. Bytes after the last whole integer are ignored."""
    raw = to_bytes(intsPackedInString)
    return list(struct.unpack_from(f"<{len(raw) // 4}i", raw))


def simxPackFloats(floatList: Sequence[float]) -> bytearray:
    """Encode numbers as 32-bit floats."""
    return bytearray(pack_floats(*floatList))


def simxUnpackFloats(floatsPackedInString: Bytes) -> list[float]:
    """Decode 32-bit floats. Bytes after the last whole float are ignored."""
    raw = to_bytes(floatsPackedInString)
    return list(struct.unpack_from(f"<{len(raw) // 4}f", raw))


def _read_results(data: memoryview) -> Results:
    """Decode the results of a script function. The data has four counts, then integers, floats, texts and bytes."""
    ints, fractions, texts, size = struct.unpack_from("<4i", data)
    whole = struct.unpack_from(f"<{ints}i", data, 16)
    real = struct.unpack_from(f"<{fractions}f", data, 16 + 4 * ints)
    *strings, rest = bytes(data[16 + 4 * (ints + fractions) :]).split(b"\0", texts)
    return list(whole), list(real), [string.decode("utf-8", "replace") for string in strings], bytearray(rest[:size])

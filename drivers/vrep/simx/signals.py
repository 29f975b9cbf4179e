"""Signals and functions of a scene's scripts, in the official binding's words."""
# ruff: noqa: N802, N803, N816, D103  the official binding's names; its manual says what they do

from __future__ import annotations

import struct
from collections.abc import Sequence

from drivers.vrep.simx import constants as c
from drivers.vrep.simx.clients import CLIENTS, read, send
from drivers.vrep.wire.requests import Request, of_name
from drivers.vrep.wire.values import pack_floats, pack_ints, read_float, read_int, read_nothing

Bytes = str | bytes | bytearray
Results = tuple[list[int], list[float], list[str], bytearray]


def simxGetFloatSignal(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, float]:
    return read(clientID, of_name("tell signal", 0x3010, signalName, read_float), operationMode, 0.0)


def simxSetFloatSignal(clientID: int, signalName: str | bytes, signalValue: float, operationMode: int) -> int:
    return _set(clientID, 0x3013, signalName, pack_floats(signalValue), operationMode)


def simxClearFloatSignal(clientID: int, signalName: str | bytes, operationMode: int) -> int:
    return _set(clientID, 0x300D, signalName, b"", operationMode)


def simxGetInt32Signal(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, int]:
    return read(clientID, of_name("tell signal", 0x3011, signalName, read_int), operationMode, 0)


def simxSetInt32Signal(clientID: int, signalName: str | bytes, signalValue: int, operationMode: int) -> int:
    return _set(clientID, 0x3014, signalName, pack_ints(signalValue), operationMode)


def simxClearInt32Signal(clientID: int, signalName: str | bytes, operationMode: int) -> int:
    return _set(clientID, 0x300E, signalName, b"", operationMode)


def simxGetStringSignal(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, bytearray]:
    return read(clientID, of_name("tell signal", 0x3012, signalName, bytearray), operationMode, bytearray())


def simxGetAndClearStringSignal(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, bytearray]:
    """Return the code and the signal. One that was streamed is given once: the server has ended its stream."""
    request = of_name("take signal", 0x3017, signalName, bytearray)
    answer = read(clientID, request, operationMode, bytearray())
    if answer[0] == c.simx_return_ok and operationMode == c.simx_opmode_buffer:
        read(clientID, request, c.simx_opmode_remove, bytearray())
    return answer


def simxReadStringStream(clientID: int, signalName: str | bytes, operationMode: int) -> tuple[int, bytearray]:
    """Return the code and what has come since the last time; it is streamed, and never waited for."""
    if operationMode == c.simx_opmode_blocking and CLIENTS.get(clientID):
        return c.simx_return_illegal_opmode_flag, bytearray()
    request = of_name("take stream", 0x3018, signalName, bytearray)
    answer = read(clientID, request, operationMode, bytearray())
    if answer[0] == c.simx_return_ok:
        read(clientID, request, c.simx_opmode_remove, bytearray())
    return answer


def simxSetStringSignal(clientID: int, signalName: str | bytes, signalValue: Bytes, operationMode: int) -> int:
    return _set(clientID, 0x3015, signalName, _raw(signalValue), operationMode)


def simxAppendStringSignal(clientID: int, signalName: str | bytes, signalValue: Bytes, operationMode: int) -> int:
    return _set(clientID, 0x3016, signalName, _raw(signalValue), operationMode)


def simxClearStringSignal(clientID: int, signalName: str | bytes, operationMode: int) -> int:
    return _set(clientID, 0x300F, signalName, b"", operationMode)


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
    key = pack_ints(options) + _terminated(scriptDescription) + _terminated(functionName)
    buffer = _raw(inputBuffer)
    counts = pack_ints(len(inputInts), len(inputFloats), len(inputStrings), len(buffer))
    numbers = pack_ints(*inputInts) + pack_floats(*inputFloats)
    data = counts + numbers + b"".join(map(_terminated, inputStrings)) + buffer
    nothing: Results = ([], [], [], bytearray())
    call = Request(f"call {functionName!r} of {scriptDescription!r}", 0x3401, key, data, _results)
    code, results = read(clientID, call, operationMode, nothing)
    return code, *results


simxClearIntegerSignal = simxClearInt32Signal
simxGetIntegerSignal = simxGetInt32Signal
simxSetIntegerSignal = simxSetInt32Signal
simxWriteStringStream = simxAppendStringSignal


def simxPackInts(intList: Sequence[int]) -> bytearray:
    return bytearray(pack_ints(*intList))


def simxUnpackInts(intsPackedInString: Bytes) -> list[int]:
    raw = _raw(intsPackedInString)
    return list(struct.unpack_from(f"<{len(raw) // 4}i", raw))


def simxPackFloats(floatList: Sequence[float]) -> bytearray:
    return bytearray(pack_floats(*floatList))


def simxUnpackFloats(floatsPackedInString: Bytes) -> list[float]:
    raw = _raw(floatsPackedInString)
    return list(struct.unpack_from(f"<{len(raw) // 4}f", raw))


def _set(client: int, command: int, name: str | bytes, data: bytes, mode: int) -> int:
    return send(client, of_name("set signal", command, name, read_nothing, data), mode)


def _raw(value: Bytes) -> bytes:
    return value.encode() if isinstance(value, str) else bytes(value)


def _terminated(text: str | bytes) -> bytes:
    return _raw(text).split(b"\0")[0] + b"\0"


def _results(data: memoryview) -> Results:
    """Return what a script's function returned: four counts; numbers, fractions, texts and bytes follow."""
    ints, fractions, texts, size = struct.unpack_from("<4i", data)
    whole = struct.unpack_from(f"<{ints}i", data, 16)
    real = struct.unpack_from(f"<{fractions}f", data, 16 + 4 * ints)
    *words, rest = bytes(data[16 + 4 * (ints + fractions) :]).split(b"\0", texts)
    return list(whole), list(real), [word.decode("utf-8", "replace") for word in words], bytearray(rest[:size])

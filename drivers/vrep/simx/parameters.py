"""Parameters of the simulator and of objects, in the official binding's words."""
# ruff: noqa: N802, N803, N816, D103  the official binding's names; its manual says what they do

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep.simx.calls import read, read_list, send
from drivers.vrep.wire import requests
from drivers.vrep.wire.requests import of_handle, of_handles
from drivers.vrep.wire.values import floats, packed_floats, packed_ints, read_float, read_int, read_nothing, read_text


def simxGetBoolParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, bool]:
    code, value = read(clientID, of_handle("tell parameter", 0x101F, paramIdentifier, read_int), operationMode, 0)
    return code, value != 0


def simxSetBoolParam(clientID: int, paramIdentifier: int, paramValue: bool, operationMode: int) -> int:  # noqa: FBT001
    return _set(clientID, 0x1020, paramIdentifier, packed_ints(bool(paramValue)), operationMode)


def simxGetInt32Param(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, int]:
    return read(clientID, requests.int_parameter(paramIdentifier), operationMode, 0)


def simxSetInt32Param(clientID: int, paramIdentifier: int, paramValue: int, operationMode: int) -> int:
    return _set(clientID, 0x1022, paramIdentifier, packed_ints(paramValue), operationMode)


def simxGetFloatParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, float]:
    return read(clientID, requests.float_parameter(paramIdentifier), operationMode, 0.0)


def simxSetFloatParam(clientID: int, paramIdentifier: int, paramValue: float, operationMode: int) -> int:
    return send(clientID, requests.set_float_parameter(paramIdentifier, paramValue), operationMode)


def simxGetStringParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, str]:
    return read(clientID, of_handle("tell parameter", 0x1025, paramIdentifier, read_text), operationMode, "")


def simxGetArrayParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, list[float]]:
    return read_list(clientID, of_handle("tell parameter", 0x101D, paramIdentifier, floats(3)), operationMode, 3)


def simxSetArrayParam(clientID: int, paramIdentifier: int, paramValues: Sequence[float], operationMode: int) -> int:
    return _set(clientID, 0x101E, paramIdentifier, packed_floats(*paramValues), operationMode)


def simxGetObjectFloatParam(
    clientID: int, objectHandle: int, parameterID: int, operationMode: int
) -> tuple[int, float]:
    request = of_handles("tell a parameter of object", 0x2007, objectHandle, parameterID, read_float)
    return read(clientID, request, operationMode, 0.0)


def simxSetObjectFloatParam(
    clientID: int, objectHandle: int, parameterID: int, parameterValue: float, operationMode: int
) -> int:
    return _set_of(clientID, 0x2009, objectHandle, parameterID, packed_floats(parameterValue), operationMode)


def simxGetObjectInt32Param(clientID: int, objectHandle: int, parameterID: int, operationMode: int) -> tuple[int, int]:
    request = of_handles("tell a parameter of object", 0x2008, objectHandle, parameterID, read_int)
    return read(clientID, request, operationMode, 0)


def simxSetObjectInt32Param(
    clientID: int, objectHandle: int, parameterID: int, parameterValue: int, operationMode: int
) -> int:
    return _set_of(clientID, 0x200A, objectHandle, parameterID, packed_ints(parameterValue), operationMode)


simxGetBooleanParameter = simxGetBoolParam
simxSetBooleanParameter = simxSetBoolParam
simxGetIntegerParameter = simxGetInt32Param
simxSetIntegerParameter = simxSetInt32Param
simxGetFloatingParameter = simxGetFloatParam
simxSetFloatingParameter = simxSetFloatParam
simxGetStringParameter = simxGetStringParam
simxGetArrayParameter = simxGetArrayParam
simxSetArrayParameter = simxSetArrayParam
simxGetObjectFloatParameter = simxGetObjectFloatParam
simxSetObjectFloatParameter = simxSetObjectFloatParam
simxGetObjectIntParameter = simxGetObjectInt32Param
simxSetObjectIntParameter = simxSetObjectInt32Param


def _set(client: int, command: int, number: int, data: bytes, mode: int) -> int:
    return send(client, of_handle("set parameter", command, number, read_nothing, data), mode)


def _set_of(client: int, command: int, handle: int, number: int, data: bytes, mode: int) -> int:
    return send(client, of_handles("set a parameter of object", command, handle, number, read_nothing, data), mode)

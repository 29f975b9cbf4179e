"""The functions of the official binding that send one command and return its answer, as a table.

Units are m, rad, N and N·m. The handle -1 stands for the world.
"""
# ruff: noqa: N816  the names of the official binding

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import GenericAlias
from typing import Any

from drivers.vrep.simx.clients import T, U, read, send
from drivers.vrep.wire.codec import (
    floats_reader,
    pack_floats,
    pack_ints,
    pack_text,
    read_errors,
    read_float,
    read_int,
    read_ints,
    read_nothing,
    read_text,
)
from drivers.vrep.wire.requests import Request

ZEROS = memoryview(bytes(64))
"""The data that is decoded if there is no answer. The value is thus zero or empty."""


@dataclass(frozen=True)
class Parameter:
    """The type of a parameter, and the function that encodes an argument."""

    annotation: Any
    encode: Callable[[Any], bytes]
    is_key: bool = False
    """Whether the argument is a part of the command's key. If False, it is a part of the command's data."""


def to_bytes(value: str | bytes | bytearray) -> bytes:
    """Encode a text, or return the bytes."""
    return value.encode() if isinstance(value, str) else bytes(value)


HANDLE = Parameter(int, pack_ints, is_key=True)
NAME = Parameter(str | bytes, pack_text, is_key=True)
INT = Parameter(int, pack_ints)
FLOAT = Parameter(float, pack_floats)
FLOATS = Parameter(Sequence[float], lambda values: pack_floats(*values))
BOOL = Parameter(bool, lambda value: pack_ints(bool(value)))
BYTE_BOOL = Parameter(bool, lambda value: bytes([bool(value)]))
BYTES = Parameter(str | bytes | bytearray, to_bytes)


def read_bool(data: memoryview) -> bool:
    """Decode a truth value."""
    return read_int(data) != 0


def build_reader(
    command: int, decode: Callable[[memoryview], T], **parameters: Parameter
) -> Callable[..., tuple[int, T]]:
    """Build a function that returns the return code and the decoded answer of a command.

    command: the number of the command.
    decode: the function that decodes the answer. Its annotation is the type of the value.
    parameters: the parameters between ``clientID`` and ``operationMode``, by name.
    """

    def execute(client: int, request: Request[T], mode: int) -> tuple[int, T]:
        """Return the return code and the value. Without an answer, the value is zero or empty."""
        return read(client, request, mode, decode(ZEROS))

    value = inspect.signature(decode, eval_str=True).return_annotation
    return _build(command, decode, parameters, execute, GenericAlias(tuple, (int, value)))


def build_writer(command: int, first_key: bytes = b"", **parameters: Parameter) -> Callable[..., int]:
    """Build a function that sends a command, and returns the return code.

    first_key: the part of the key before the arguments. For the other parameters see `build_reader`.
    """

    def execute(client: int, request: Request[None], mode: int) -> int:
        """Send the command, and return the return code."""
        return send(client, request, mode)

    return _build(command, read_nothing, parameters, execute, int, first_key)


def _build(
    command: int,
    decode: Callable[[memoryview], T],
    parameters: dict[str, Parameter],
    execute: Callable[[int, Request[T], int], U],
    returns: Any,
    first_key: bytes = b"",
) -> Callable[..., U]:
    types = {"clientID": int, **{name: each.annotation for name, each in parameters.items()}, "operationMode": int}
    listed = [
        inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=types[name]) for name in types
    ]
    signature = inspect.Signature(listed, return_annotation=returns)

    def call(*args: Any, **kwargs: Any) -> U:
        if kwargs or len(args) != len(types):
            try:
                args = signature.bind(*args, **kwargs).args
            except TypeError as error:
                raise TypeError(f"{call.__name__}: {error}. Its parameters are {', '.join(types)}") from None
        client, *values, mode = args
        encoded = [(each.is_key, each.encode(value)) for each, value in zip(parameters.values(), values, strict=True)]
        key = first_key + b"".join(part for is_key, part in encoded if is_key)
        data = b"".join(part for is_key, part in encoded if not is_key)
        return execute(client, Request(call.__name__, command, key, data, decode), mode)

    call.__signature__ = signature  # type: ignore[attr-defined]
    call.__annotations__, call.__doc__ = {**types, "return": returns}, execute.__doc__
    return call


simxGetObjectHandle = build_reader(0x3001, read_int, objectName=NAME)
simxGetCollectionHandle = build_reader(0x3019, read_int, collectionName=NAME)
simxGetObjectPosition = build_reader(0x200E, floats_reader(3), objectHandle=HANDLE, relativeToObjectHandle=HANDLE)
simxSetObjectPosition = build_writer(0x101B, objectHandle=HANDLE, relativeToObjectHandle=INT, position=FLOATS)
simxGetObjectOrientation = build_reader(0x200D, floats_reader(3), objectHandle=HANDLE, relativeToObjectHandle=HANDLE)
simxSetObjectOrientation = build_writer(0x101A, objectHandle=HANDLE, relativeToObjectHandle=INT, eulerAngles=FLOATS)
simxGetObjectQuaternion = build_reader(0x2801, floats_reader(4), objectHandle=HANDLE, relativeToObjectHandle=HANDLE)
simxSetObjectQuaternion = build_writer(0x1801, objectHandle=HANDLE, relativeToObjectHandle=INT, quaternion=FLOATS)
simxGetObjectParent = build_reader(0x1012, read_int, childObjectHandle=HANDLE)
simxSetObjectParent = build_writer(0x101C, objectHandle=HANDLE, parentObject=INT, keepInPlace=BYTE_BOOL)
simxGetObjectChild = build_reader(0x200B, read_int, parentObjectHandle=HANDLE, childIndex=HANDLE)
simxGetObjects = build_reader(0x102A, read_ints, objectType=HANDLE)
simxRemoveObject = build_writer(0x1028, objectHandle=HANDLE)
simxRemoveModel = build_writer(0x1037, objectHandle=HANDLE)
simxCheckCollision = build_reader(0x200F, read_bool, entity1=HANDLE, entity2=HANDLE)
simxCheckDistance = build_reader(0x2010, read_float, entity1=HANDLE, entity2=HANDLE)

simxGetJointPosition = build_reader(0x1001, read_float, jointHandle=HANDLE)
simxSetJointPosition = build_writer(0x1002, jointHandle=HANDLE, position=FLOAT)
simxSetJointTargetVelocity = build_writer(0x1008, jointHandle=HANDLE, targetVelocity=FLOAT)
simxSetJointTargetPosition = build_writer(0x100C, jointHandle=HANDLE, targetPosition=FLOAT)
simxGetJointMatrix = build_reader(0x100A, floats_reader(12), jointHandle=HANDLE)
simxSetSphericalJointMatrix = build_writer(0x100B, jointHandle=HANDLE, matrix=FLOATS)
simxGetJointForce = build_reader(0x100D, read_float, jointHandle=HANDLE)
simxGetJointMaxForce = build_reader(0x1038, read_float, jointHandle=HANDLE)
simxSetJointMaxForce = build_writer(0x100E, jointHandle=HANDLE, force=FLOAT)

simxGetBoolParam = build_reader(0x101F, read_bool, paramIdentifier=HANDLE)
simxSetBoolParam = build_writer(0x1020, paramIdentifier=HANDLE, paramValue=BOOL)
simxGetInt32Param = build_reader(0x1021, read_int, paramIdentifier=HANDLE)
simxSetInt32Param = build_writer(0x1022, paramIdentifier=HANDLE, paramValue=INT)
simxGetFloatParam = build_reader(0x1023, read_float, paramIdentifier=HANDLE)
simxSetFloatParam = build_writer(0x1024, paramIdentifier=HANDLE, paramValue=FLOAT)
simxGetStringParam = build_reader(0x1025, read_text, paramIdentifier=HANDLE)
simxGetArrayParam = build_reader(0x101D, floats_reader(3), paramIdentifier=HANDLE)
simxSetArrayParam = build_writer(0x101E, paramIdentifier=HANDLE, paramValues=FLOATS)
simxGetObjectFloatParam = build_reader(0x2007, read_float, objectHandle=HANDLE, parameterID=HANDLE)
simxSetObjectFloatParam = build_writer(0x2009, objectHandle=HANDLE, parameterID=HANDLE, parameterValue=FLOAT)
simxGetObjectInt32Param = build_reader(0x2008, read_int, objectHandle=HANDLE, parameterID=HANDLE)
simxSetObjectInt32Param = build_writer(0x200A, objectHandle=HANDLE, parameterID=HANDLE, parameterValue=INT)

simxGetFloatSignal = build_reader(0x3010, read_float, signalName=NAME)
simxSetFloatSignal = build_writer(0x3013, signalName=NAME, signalValue=FLOAT)
simxClearFloatSignal = build_writer(0x300D, signalName=NAME)
simxGetInt32Signal = build_reader(0x3011, read_int, signalName=NAME)
simxSetInt32Signal = build_writer(0x3014, signalName=NAME, signalValue=INT)
simxClearInt32Signal = build_writer(0x300E, signalName=NAME)
simxSetStringSignal = build_writer(0x3015, signalName=NAME, signalValue=BYTES)
simxAppendStringSignal = build_writer(0x3016, signalName=NAME, signalValue=BYTES)
simxClearStringSignal = build_writer(0x300F, signalName=NAME)

simxAddStatusbarMessage = build_writer(0x3008, message=NAME)
simxCloseScene = build_writer(0x0005)
simxStartSimulation = build_writer(0x1007, pack_ints(0))
simxPauseSimulation = build_writer(0x1007, pack_ints(1))
simxStopSimulation = build_writer(0x1007, pack_ints(2))
simxGetLastErrors = build_reader(0x0004, read_errors)

for _name, _function in list(globals().items()):  # the names that help() shows, not those of the aliases below
    if _name.startswith("simx"):
        _function.__name__ = _function.__qualname__ = _name

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
simxJointGetForce = simxGetJointForce
simxSetJointForce = simxSetJointMaxForce
simxClearIntegerSignal = simxClearInt32Signal
simxGetIntegerSignal = simxGetInt32Signal
simxSetIntegerSignal = simxSetInt32Signal
simxWriteStringStream = simxAppendStringSignal

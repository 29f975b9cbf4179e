"""The functions of the official binding about objects, joints and parameters.

Units are m, rad, N and N·m. The handle -1 stands for the world.
"""
# ruff: noqa: N802, N803, N816, D103  the names and short functions of the official binding; its manual explains them

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep.simx.clients import read, read_list, send
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import (
    floats_reader,
    pack_floats,
    pack_ints,
    read_float,
    read_int,
    read_nothing,
    read_text,
)
from drivers.vrep.wire.requests import named_request, object_request, pair_request


def simxGetObjectHandle(clientID: int, objectName: str | bytes, operationMode: int) -> tuple[int, int]:
    return read(clientID, requests.object_handle(objectName), operationMode, 0)


def simxGetCollectionHandle(clientID: int, collectionName: str | bytes, operationMode: int) -> tuple[int, int]:
    return read(clientID, named_request("find collection", 0x3019, collectionName, read_int), operationMode, 0)


def simxGetObjectPosition(
    clientID: int, objectHandle: int, relativeToObjectHandle: int, operationMode: int
) -> tuple[int, list[float]]:
    return read_list(clientID, requests.object_position(objectHandle, relativeToObjectHandle), operationMode, 3)


def simxSetObjectPosition(
    clientID: int, objectHandle: int, relativeToObjectHandle: int, position: Sequence[float], operationMode: int
) -> int:
    return _place(clientID, 0x101B, objectHandle, relativeToObjectHandle, position, operationMode)


def simxGetObjectOrientation(
    clientID: int, objectHandle: int, relativeToObjectHandle: int, operationMode: int
) -> tuple[int, list[float]]:
    return read_list(clientID, requests.object_orientation(objectHandle, relativeToObjectHandle), operationMode, 3)


def simxSetObjectOrientation(
    clientID: int, objectHandle: int, relativeToObjectHandle: int, eulerAngles: Sequence[float], operationMode: int
) -> int:
    return _place(clientID, 0x101A, objectHandle, relativeToObjectHandle, eulerAngles, operationMode)


def simxGetObjectQuaternion(
    clientID: int, objectHandle: int, relativeToObjectHandle: int, operationMode: int
) -> tuple[int, list[float]]:
    request = pair_request(
        "read the quaternion of object", 0x2801, objectHandle, relativeToObjectHandle, floats_reader(4)
    )
    return read_list(clientID, request, operationMode, 4)


def simxSetObjectQuaternion(
    clientID: int, objectHandle: int, relativeToObjectHandle: int, quaternion: Sequence[float], operationMode: int
) -> int:
    return _place(clientID, 0x1801, objectHandle, relativeToObjectHandle, quaternion, operationMode)


def simxGetObjectVelocity(clientID: int, objectHandle: int, operationMode: int) -> tuple[int, list[float], list[float]]:
    code, values = read_list(clientID, requests.object_velocity(objectHandle), operationMode, 6)
    return code, values[:3], values[3:]


def simxGetObjectParent(clientID: int, childObjectHandle: int, operationMode: int) -> tuple[int, int]:
    return read(clientID, requests.object_parent(childObjectHandle), operationMode, 0)


def simxSetObjectParent(
    clientID: int,
    objectHandle: int,
    parentObject: int,
    keepInPlace: bool,  # noqa: FBT001
    operationMode: int,
) -> int:
    data = pack_ints(parentObject) + bytes([bool(keepInPlace)])
    return send(
        clientID,
        object_request("set the parent of object", 0x101C, objectHandle, read_nothing, data),
        operationMode,
    )


def simxGetObjectChild(clientID: int, parentObjectHandle: int, childIndex: int, operationMode: int) -> tuple[int, int]:
    request = pair_request("read a child of object", 0x200B, parentObjectHandle, childIndex, read_int)
    return read(clientID, request, operationMode, 0)


def simxGetObjects(clientID: int, objectType: int, operationMode: int) -> tuple[int, list[int]]:
    return read(clientID, requests.objects(objectType), operationMode, [])


def simxRemoveObject(clientID: int, objectHandle: int, operationMode: int) -> int:
    return send(clientID, object_request("remove object", 0x1028, objectHandle, read_nothing), operationMode)


def simxRemoveModel(clientID: int, objectHandle: int, operationMode: int) -> int:
    return send(clientID, object_request("remove model", 0x1037, objectHandle, read_nothing), operationMode)


def simxCheckCollision(clientID: int, entity1: int, entity2: int, operationMode: int) -> tuple[int, bool]:
    request = pair_request("check collisions of object", 0x200F, entity1, entity2, read_int)
    code, value = read(clientID, request, operationMode, 0)
    return code, value != 0


def simxCheckDistance(clientID: int, entity1: int, entity2: int, operationMode: int) -> tuple[int, float]:
    request = pair_request("check the distance of object", 0x2010, entity1, entity2, read_float)
    return read(clientID, request, operationMode, 0.0)


def _place(client: int, command: int, handle: int, relative_to: int, values: Sequence[float], mode: int) -> int:
    data = pack_ints(relative_to) + pack_floats(*values)
    return send(client, object_request("place object", command, handle, read_nothing, data), mode)


def simxGetJointPosition(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, float]:
    return read(clientID, requests.joint_position(jointHandle), operationMode, 0.0)


def simxSetJointPosition(clientID: int, jointHandle: int, position: float, operationMode: int) -> int:
    return _set_joint(clientID, 0x1002, jointHandle, [position], operationMode)


def simxSetJointTargetVelocity(clientID: int, jointHandle: int, targetVelocity: float, operationMode: int) -> int:
    return send(clientID, requests.joint_target_velocity(jointHandle, targetVelocity), operationMode)


def simxSetJointTargetPosition(clientID: int, jointHandle: int, targetPosition: float, operationMode: int) -> int:
    return _set_joint(clientID, 0x100C, jointHandle, [targetPosition], operationMode)


def simxGetJointMatrix(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, list[float]]:
    return read_list(
        clientID,
        object_request("read the matrix of joint", 0x100A, jointHandle, floats_reader(12)),
        operationMode,
        12,
    )


def simxSetSphericalJointMatrix(clientID: int, jointHandle: int, matrix: Sequence[float], operationMode: int) -> int:
    return _set_joint(clientID, 0x100B, jointHandle, matrix, operationMode)


def simxGetJointForce(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, float]:
    return read(
        clientID, object_request("read the force of joint", 0x100D, jointHandle, read_float), operationMode, 0.0
    )


def simxGetJointMaxForce(clientID: int, jointHandle: int, operationMode: int) -> tuple[int, float]:
    return read(
        clientID, object_request("read the force of joint", 0x1038, jointHandle, read_float), operationMode, 0.0
    )


def simxSetJointMaxForce(clientID: int, jointHandle: int, force: float, operationMode: int) -> int:
    return _set_joint(clientID, 0x100E, jointHandle, [force], operationMode)


simxJointGetForce = simxGetJointForce
simxSetJointForce = simxSetJointMaxForce


def _set_joint(client: int, command: int, joint: int, values: Sequence[float], mode: int) -> int:
    return send(client, object_request("set joint", command, joint, read_nothing, pack_floats(*values)), mode)


def simxGetBoolParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, bool]:
    code, value = read(clientID, object_request("read parameter", 0x101F, paramIdentifier, read_int), operationMode, 0)
    return code, value != 0


def simxSetBoolParam(clientID: int, paramIdentifier: int, paramValue: bool, operationMode: int) -> int:  # noqa: FBT001
    return _set_parameter(clientID, 0x1020, paramIdentifier, pack_ints(bool(paramValue)), operationMode)


def simxGetInt32Param(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, int]:
    return read(clientID, requests.int_parameter(paramIdentifier), operationMode, 0)


def simxSetInt32Param(clientID: int, paramIdentifier: int, paramValue: int, operationMode: int) -> int:
    return _set_parameter(clientID, 0x1022, paramIdentifier, pack_ints(paramValue), operationMode)


def simxGetFloatParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, float]:
    return read(clientID, requests.float_parameter(paramIdentifier), operationMode, 0.0)


def simxSetFloatParam(clientID: int, paramIdentifier: int, paramValue: float, operationMode: int) -> int:
    return send(clientID, requests.set_float_parameter(paramIdentifier, paramValue), operationMode)


def simxGetStringParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, str]:
    return read(clientID, object_request("read parameter", 0x1025, paramIdentifier, read_text), operationMode, "")


def simxGetArrayParam(clientID: int, paramIdentifier: int, operationMode: int) -> tuple[int, list[float]]:
    return read_list(
        clientID,
        object_request("read parameter", 0x101D, paramIdentifier, floats_reader(3)),
        operationMode,
        3,
    )


def simxSetArrayParam(clientID: int, paramIdentifier: int, paramValues: Sequence[float], operationMode: int) -> int:
    return _set_parameter(clientID, 0x101E, paramIdentifier, pack_floats(*paramValues), operationMode)


def simxGetObjectFloatParam(
    clientID: int, objectHandle: int, parameterID: int, operationMode: int
) -> tuple[int, float]:
    request = pair_request("read a parameter of object", 0x2007, objectHandle, parameterID, read_float)
    return read(clientID, request, operationMode, 0.0)


def simxSetObjectFloatParam(
    clientID: int, objectHandle: int, parameterID: int, parameterValue: float, operationMode: int
) -> int:
    return _set_object_parameter(
        clientID, 0x2009, objectHandle, parameterID, pack_floats(parameterValue), operationMode
    )


def simxGetObjectInt32Param(clientID: int, objectHandle: int, parameterID: int, operationMode: int) -> tuple[int, int]:
    request = pair_request("read a parameter of object", 0x2008, objectHandle, parameterID, read_int)
    return read(clientID, request, operationMode, 0)


def simxSetObjectInt32Param(
    clientID: int, objectHandle: int, parameterID: int, parameterValue: int, operationMode: int
) -> int:
    return _set_object_parameter(clientID, 0x200A, objectHandle, parameterID, pack_ints(parameterValue), operationMode)


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


def _set_parameter(client: int, command: int, number: int, data: bytes, mode: int) -> int:
    return send(client, object_request("set parameter", command, number, read_nothing, data), mode)


def _set_object_parameter(client: int, command: int, handle: int, number: int, data: bytes, mode: int) -> int:
    return send(client, pair_request("set a parameter of object", command, handle, number, read_nothing, data), mode)

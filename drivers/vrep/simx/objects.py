"""Objects, in the official binding's words: metres, radians, and -1 for the world."""
# ruff: noqa: N802, N803, D103  the official binding's names; its manual says what they do

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep.simx.calls import read, read_list, send
from drivers.vrep.wire import requests
from drivers.vrep.wire.requests import of_handle, of_handles, of_name
from drivers.vrep.wire.values import floats, packed_floats, packed_ints, read_float, read_int, read_nothing


def simxGetObjectHandle(clientID: int, objectName: str | bytes, operationMode: int) -> tuple[int, int]:
    return read(clientID, requests.object_handle(objectName), operationMode, 0)


def simxGetCollectionHandle(clientID: int, collectionName: str | bytes, operationMode: int) -> tuple[int, int]:
    return read(clientID, of_name("find collection", 0x3019, collectionName, read_int), operationMode, 0)


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
    request = of_handles("tell the quaternion of object", 0x2801, objectHandle, relativeToObjectHandle, floats(4))
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
    data = packed_ints(parentObject) + bytes([bool(keepInPlace)])
    return send(clientID, of_handle("give a parent to object", 0x101C, objectHandle, read_nothing, data), operationMode)


def simxGetObjectChild(clientID: int, parentObjectHandle: int, childIndex: int, operationMode: int) -> tuple[int, int]:
    request = of_handles("tell a child of object", 0x200B, parentObjectHandle, childIndex, read_int)
    return read(clientID, request, operationMode, 0)


def simxGetObjects(clientID: int, objectType: int, operationMode: int) -> tuple[int, list[int]]:
    return read(clientID, requests.objects(objectType), operationMode, [])


def simxRemoveObject(clientID: int, objectHandle: int, operationMode: int) -> int:
    return send(clientID, of_handle("remove object", 0x1028, objectHandle, read_nothing), operationMode)


def simxRemoveModel(clientID: int, objectHandle: int, operationMode: int) -> int:
    return send(clientID, of_handle("remove model", 0x1037, objectHandle, read_nothing), operationMode)


def simxCheckCollision(clientID: int, entity1: int, entity2: int, operationMode: int) -> tuple[int, bool]:
    request = of_handles("check collisions of object", 0x200F, entity1, entity2, read_int)
    code, value = read(clientID, request, operationMode, 0)
    return code, value != 0


def simxCheckDistance(clientID: int, entity1: int, entity2: int, operationMode: int) -> tuple[int, float]:
    request = of_handles("check the distance of object", 0x2010, entity1, entity2, read_float)
    return read(clientID, request, operationMode, 0.0)


def _place(client: int, command: int, handle: int, relative_to: int, values: Sequence[float], mode: int) -> int:
    data = packed_ints(relative_to) + packed_floats(*values)
    return send(client, of_handle("place object", command, handle, read_nothing, data), mode)

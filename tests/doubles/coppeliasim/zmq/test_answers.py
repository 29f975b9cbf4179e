"""Answers of a real CoppeliaSim 4.10 that the recorded sessions do not have."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.zmq.raw_client import RawClient, connect_clients

JOINT, CUBOID, SPHERE, EYE, NOSE, LINK, POINT = range(15, 22)
SENSOR_INTS, SENSOR_FLOATS = [16, 12, 0, 0], [0.02, 5.0, 1.0, 0.02, 0, 0, 0, 0, 0, 0, 0]
NOSE_FLOATS = [0.0, 2.0, 0.1, 0.1, 0.1, 0.1, 0.0, 0.1, 0.1, 0.5, 0.1, 0.1, 0.01, 0, 0]

Call = tuple[Any, ...]

MADE: tuple[Call, ...] = (
    ("createJoint", 10, 5, 0, [0.08, 0.015]),
    ("createPrimitiveShape", 3, [0.1, 0.2, 0.3], 0),
    ("createPrimitiveShape", 4, [0.1, 0.1, 0.1], 0),
    ("createVisionSensor", 2, SENSOR_INTS, SENSOR_FLOATS),
    ("createProximitySensor", 33, 16, 0, [8, 0, 4, 1, 1, 1, 0, 0], NOSE_FLOATS),
    ("createForceSensor", 0, [0, 1, 1, 0, 0], [0.01, 100.0, 100.0, 0, 0]),
    ("createDummy", 0.01),
)

ANSWERS: tuple[tuple[Call, Any], ...] = (
    (("isHandle", 999), [False]),
    (("isHandle", 0), [True]),
    (("getJointMode", JOINT), [5, 0]),
    (("getJointType", JOINT), [10]),
    (("getJointTargetForce", JOINT), [2.5]),
    (("setJointMaxForce", JOINT, 1.0), [1]),
    (("setJointPosition", JOINT, 1.0), [1]),
    (("setJointMode", JOINT, 0, 0), [1]),
    (("setJointInterval", JOINT, True, [0, 0]), [1]),
    (("getObjectInt32Param", JOINT, 2039), [0]),
    (("getObjectAlias", JOINT), ["Revolute_joint"]),
    (("getObjectAlias", JOINT, 2), ["/Revolute_joint"]),
    (("getObjectAlias", JOINT, 4), ["Revolute_joint__15__"]),
    (("getObjectAlias", CUBOID), ["Cuboid"]),
    (("getObjectAlias", SPHERE), ["Sphere"]),
    (("getObjectAlias", EYE), ["visionSensor"]),
    (("getObjectAlias", NOSE), ["proximitySensor"]),
    (("getObjectAlias", LINK), ["forceSensor"]),
    (("getObjectAlias", POINT), ["dummy"]),
    (("getObjectInt32Param", CUBOID, 3003), [1]),
    (("getObjectInt32Param", CUBOID, 3004), [0]),
    (("getObjectInt32Param", CUBOID, 3019), [65535]),
    (("getShapeGeomInfo", CUBOID), [6, 3, [0.1, 0.2, 0.3, 0.0]]),
    (("getShapeMass", CUBOID), [pytest.approx(3.0)]),
    (("getShapeColor", CUBOID, None, 0), [1, [1.0, 1.0, 1.0]]),
    (("getShapeBB", CUBOID), [[0.1, 0.2, 0.3], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]),
    (("getObjectSpecialProperty", CUBOID), [1011]),
    (("getObjectProperty", CUBOID), [32]),
    (("getModelProperty", CUBOID), [61440]),
    (("resetDynamicObject", CUBOID), [1]),
    (("setShapeMass", CUBOID, 2.0), {}),
    (("getObjectVelocity", CUBOID), [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
    (("writeCustomStringData", CUBOID, "tag", "hello"), [1]),
    (("getVisionSensorRes", EYE), [[16, 12]]),
    (("getVisionSensorImg", EYE, 0, 0.0, [0, 0], [2, 2]), [bytes(12), [16, 12]]),
    (("getObjectFloatParam", EYE, 1004), [1.0]),
    (("getObjectInt32Param", EYE, 1002), [16]),
    (("setVisionSensorImg", EYE, bytes(16 * 12 * 3)), [1]),
    (("getExplicitHandling", EYE), [0]),
    (("readProximitySensor", NOSE), [0, 0.0, [0.0] * 3, -1, [0.0] * 3]),
    (("getObjectChild", JOINT, 0), [-1]),
    (("getObjectsInTree", JOINT), [[15]]),
    (("getObjectsInTree", JOINT, -2, 1), [[]]),
    (("getObjects", 0, 1), [15]),
    (("getObjects", 0, 99), [-1]),
    (("removeObject", POINT), [1]),
    (("getBoolParam", 25), [False]),
    (("getArrayParam", 0), [[0.0, 0.0, -9.8100004196167]]),
    (("setStringSignal", "a", "b"), [1]),
    (("setNamedStringParam", "a", "b"), [1]),
    (("createCollection", 0), [2000000]),
    (("getContactInfo", -2, -2, 0), [[], [], [], []]),
)

REFUSED: tuple[tuple[Call, str], ...] = (
    (("getObject", "Floor"), "1254: in sim._getObject: object does not exist, or alias/path is ill formatted."),
    (("getObjectHandle", "F"), "1272: in sim._getObjectHandle: object does not exist, or alias/path is ill formatted."),
    (("getJointTargetVelocity", 0), "354: in sim.getJointTargetVelocity: object is not a joint."),
    (("getVisionSensorImg", 0), "354: in sim.getVisionSensorImg: object is not a vision sensor."),
    (("readProximitySensor", 0), "354: in sim.readProximitySensor: object is not a proximity sensor."),
    (("getObjectType", 999), "354: in sim.getObjectType: object does not exist."),
    (("setObjectPosition", 0, [1, 2]), "354: in sim.setObjectPosition: incorrect table size."),
    (("setObjectPosition", 0), "354: in sim.setObjectPosition: the function requires more arguments."),
    (("setJointTargetVelocity", JOINT, "a"), "354: in sim.setJointTargetVelocity: argument 2 is not a number."),
    (("setVisionSensorImg", EYE, b"123"), "354: in sim.setVisionSensorImg: incorrect buffer size."),
    (("handleProximitySensor", NOSE), "354: in sim.handleProximitySensor: object not tagged for explicit handling."),
    (("removeObjects", [999]), "354: in sim.removeObjects: found invalid handles."),
    (("removeModel", LINK), "354: in sim.removeModel: object is not tagged as model base."),
    (("createPrimitiveShape", 3, [0.1]), "354: in sim.createPrimitiveShape: incorrect table size."),
    (("addItemToCollection", 1, -6, 0, 0), "354: in sim.addItemToCollection: collection does not exist."),
)


@pytest.fixture
def client() -> Iterator[RawClient]:
    with Double(default_scene()) as double, connect_clients(double.zmq_port, "one") as (talker,):
        for name, *args in MADE:
            talker.call(f"sim.{name}", *args)
        yield talker


def test_answers_equal_those_of_the_real_server(client: RawClient) -> None:
    for (name, *args), expected in ANSWERS:
        assert (name, args, client.call(f"sim.{name}", *args)) == (name, args, {"ret": expected})


def test_errors_equal_those_of_the_real_server(client: RawClient) -> None:
    for (name, *args), expected in REFUSED:
        assert client.call(f"sim.{name}", *args) == {"err": expected}


def test_invalid_arguments_are_answered(client: RawClient) -> None:
    for call in (("setShapeColor", CUBOID, None, 0, ["red"] * 3), ("getObject", "/a", 7), ("removeObjects", 5)):
        assert "err" in client.call(f"sim.{call[0]}", *call[1:])
    assert client.call("sim.isHandle", 0) == {"ret": [True]}

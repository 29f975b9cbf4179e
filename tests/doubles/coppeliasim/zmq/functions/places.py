"""Where objects are: poses, positions, turns; relative to the world, to a parent, or to another object."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene.objects import Thing
from tests.doubles.coppeliasim.scene.poses import Transform, euler_of, of_euler, unit
from tests.doubles.coppeliasim.zmq.functions.registry import floats, function
from tests.doubles.coppeliasim.zmq.session import Session

WORLD = -1
PARENT = -11


@function("getObjectPose")
def get_object_pose(session: Session, thing: Thing, relative_to: int = WORLD) -> list[float]:
    return _place(session, thing, relative_to).pose


@function("setObjectPose")
def set_object_pose(session: Session, thing: Thing, pose: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    _put(session, thing, Transform.of_pose(floats(pose, 7)), relative_to)


@function("getObjectPosition")
def get_object_position(session: Session, thing: Thing, relative_to: int = WORLD) -> list[float]:
    return list(_place(session, thing, relative_to).position)


@function("setObjectPosition")
def set_object_position(session: Session, thing: Thing, position: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    x, y, z = floats(position, 3)
    _put(session, thing, _place(session, thing, relative_to)._replace(position=(x, y, z)), relative_to)


@function("getObjectOrientation")
def get_object_orientation(session: Session, thing: Thing, relative_to: int = WORLD) -> list[float]:
    return euler_of(_place(session, thing, relative_to).quaternion)


@function("setObjectOrientation")
def set_object_orientation(session: Session, thing: Thing, angles: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    quaternion = of_euler(floats(angles, 3))
    _put(session, thing, _place(session, thing, relative_to)._replace(quaternion=quaternion), relative_to)


@function("getObjectQuaternion")
def get_object_quaternion(session: Session, thing: Thing, relative_to: int = WORLD) -> list[float]:
    return list(_place(session, thing, relative_to).quaternion)


@function("setObjectQuaternion")
def set_object_quaternion(session: Session, thing: Thing, quaternion: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    x, y, z, w = floats(quaternion, 4)
    _put(session, thing, _place(session, thing, relative_to)._replace(quaternion=unit((x, y, z, w))), relative_to)


@function("getObjectMatrix")
def get_object_matrix(session: Session, thing: Thing, relative_to: int = WORLD) -> list[float]:
    place = _place(session, thing, relative_to)
    return [part for row in zip(*place.axes, place.position, strict=True) for part in row]


@function("getObjectVelocity")
def get_object_velocity(session: Session, thing: Thing) -> tuple[list[float], list[float]]:
    linear, angular = session.simulator.velocity(thing)
    return list(linear), list(angular)


def _place(session: Session, thing: Thing, relative_to: int) -> Transform:
    if relative_to == PARENT:
        return thing.local
    graph = session.simulator.graph
    pose = graph.pose(thing)
    return pose if relative_to == WORLD else graph.pose(graph[relative_to]).inverse.then(pose)


def _put(session: Session, thing: Thing, place: Transform, relative_to: int) -> None:
    graph = session.simulator.graph
    if relative_to == WORLD:
        graph.put(thing, place)
    elif relative_to == PARENT:
        graph.put(thing, graph.frame(thing.parent).then(place))
    else:
        graph.put(thing, graph.pose(graph[relative_to]).then(place))

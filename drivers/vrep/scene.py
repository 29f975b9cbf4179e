"""A scene behind the legacy remote API: the parts that lockstep and streaming have in common."""

from __future__ import annotations

import struct
from abc import abstractmethod
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header, read_float, read_int
from drivers.vrep.wire.errors import RefusedError
from drivers.vrep.wire.requests import Request, of_handles
from robotcore.simulation.remote_scene import (
    CameraOptics,
    ObjectKind,
    Point,
    RawPicture,
    Scene,
    SceneObject,
    State,
    compute_horizontal_fov,
)

T = TypeVar("T")

TIME_STEP = 1
"""A floating parameter: ``sim_floatparam_simulation_time_step``."""

STARTS = 3
"""So often is a simulation started whose time does not move: servers have been seen to need a second start."""

KINDS = {0: ObjectKind.SHAPE, 1: ObjectKind.JOINT, 5: ObjectKind.PROXIMITY_SENSOR, 9: ObjectKind.VISION_SENSOR}


class LegacyScene(Scene):
    """Asks for things of a scene; how, is the business of those that derive from it."""

    @abstractmethod
    def _once(self, request: Request[T]) -> T:
        """Return the answer to what is asked once; raises RefusedError where the server cannot."""

    @abstractmethod
    def _newest(self, request: Request[T]) -> T:
        """Return the newest answer to what is asked again and again."""

    @abstractmethod
    def _tell(self, request: Request[None]) -> None:
        """Send something that is not answered."""

    @property
    @abstractmethod
    def _server(self) -> Header:
        """How things are with the server."""

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self._once(requests.object_handle(path))
        except RefusedError:
            return None
        return SceneObject(handle, path, self._kinds.get(handle, ObjectKind.OTHER))

    def list_objects(self) -> list[SceneObject]:
        """Return all objects under their names: this API does not tell their paths."""
        named = self._once(NAMES)
        return [
            SceneObject(handle, name, self._kinds.get(handle, ObjectKind.OTHER))
            for handle, name in zip(named.handles, named.texts, strict=False)
        ]

    def read_state(self) -> State:
        self._once(requests.CLOCK)
        if not self._server.is_running:
            return State.STOPPED
        return State.PAUSED if self._server.is_paused else State.RUNNING

    def read_time_step(self) -> float:
        return self._once(requests.float_parameter(TIME_STEP))

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._tell(requests.joint_target_velocity(joint, rad_s))

    def read_joint_position(self, joint: int) -> float:
        return self._newest(requests.joint_position(joint))

    def detect(self, sensor: int) -> Point | None:
        seen = self._newest(requests.proximity(sensor))
        return _point(seen.point) if seen.is_detected else None

    def read_optics(self, sensor: int) -> CameraOptics:
        width, height = self._once(columns(sensor)), self._once(rows(sensor))
        return CameraOptics(width, height, compute_horizontal_fov(self._once(view_angle(sensor)), width, height))

    def read_picture(self, sensor: int) -> RawPicture:
        pixels = self._newest(requests.colour_image(sensor))
        return RawPicture(pixels.data, pixels.shape[1], pixels.shape[0])

    def show(self, sensor: int, picture: RawPicture) -> None:
        self._tell(requests.set_colour_image(sensor, bytes(picture.pixels)))

    def read_position(self, handle: int) -> Point:
        return _point(self._newest(requests.object_position(handle)))

    @cached_property
    def _kinds(self) -> dict[int, ObjectKind]:
        types = self._once(TYPES)
        return {
            handle: KINDS.get(number, ObjectKind.OTHER)
            for handle, number in zip(types.handles, types.numbers, strict=False)
        }


def velocity_between(before: Point, after: Point, seconds: float) -> Point:
    """Return the velocity of what has moved so in that time."""
    return _point([(there - here) / seconds for here, there in zip(before, after, strict=True)])


def _point(values: list[float] | tuple[float, ...]) -> Point:
    x, y, z = values
    return x, y, z


EVERYTHING = 109
"""All objects of a scene: ``sim_appobj_object_type``."""

NAMES_OF, TYPES_OF = 0, 1
"""What is to be told of a group of objects."""

RESOLUTION_X, RESOLUTION_Y, VIEW_ANGLE = 1002, 1003, 1004


class Group(NamedTuple):
    """What a server tells of many objects at once: their handles, and whole numbers or texts, one of each."""

    handles: tuple[int, ...]
    numbers: tuple[int, ...]
    texts: tuple[str, ...]


def read_group(data: memoryview) -> Group:
    """Return the four counts' worth of handles, whole numbers, floats (which are left out), and texts.

    As ``simxGetObjectGroupData`` in the maker's extApi.c reads them.
    """
    handles, numbers, floats, texts = struct.unpack_from("<4i", data)
    if min(handles, numbers, floats, texts) < 0:
        raise ValueError("a count below zero")
    whole = struct.unpack_from(f"<{handles + numbers}i", data, 16)
    rest = bytes(data[16 + 4 * (handles + numbers + floats) :])
    words = tuple(part.decode("utf-8", "replace") for part in rest.split(b"\0")[:texts])
    return Group(whole[:handles], whole[handles:], words)


NAMES: Request[Group] = of_handles("name the objects of the scene", 0x200C, EVERYTHING, NAMES_OF, read_group)
TYPES: Request[Group] = of_handles("tell the types of the scene's objects", 0x200C, EVERYTHING, TYPES_OF, read_group)


def columns(sensor: int) -> Request[int]:
    """How many pixels wide a vision sensor's picture is."""
    return _parameter(sensor, 0x2008, RESOLUTION_X, read_int)


def rows(sensor: int) -> Request[int]:
    """How many pixels high a vision sensor's picture is."""
    return _parameter(sensor, 0x2008, RESOLUTION_Y, read_int)


def view_angle(sensor: int) -> Request[float]:
    """The angle that the longer side of a vision sensor's picture takes in, in rad."""
    return _parameter(sensor, 0x2007, VIEW_ANGLE, read_float)


def _parameter(sensor: int, command: int, number: int, decode: Any) -> Request[Any]:
    return of_handles("tell a parameter of vision sensor", command, sensor, number, decode)

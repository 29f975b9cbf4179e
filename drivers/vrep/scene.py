"""The base class of the scenes over the legacy remote API, with and without lockstep."""

from __future__ import annotations

import struct
from abc import abstractmethod
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header, read_float, read_int
from drivers.vrep.wire.errors import RefusedError
from drivers.vrep.wire.requests import Request, pair_request
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
"""The number of ``sim_floatparam_simulation_time_step``."""

STARTS = 3
"""The number of attempts to start a simulation. On some servers, the time advances only after the second start."""

KINDS = {0: ObjectKind.SHAPE, 1: ObjectKind.JOINT, 5: ObjectKind.PROXIMITY_SENSOR, 9: ObjectKind.VISION_SENSOR}


class LegacyScene(Scene):
    """A scene over the legacy remote API. A subclass sends the requests, and receives the answers."""

    @abstractmethod
    def _execute(self, request: Request[T]) -> T:
        """Send a request, and return the value of its answer. Raises RefusedError if the server refuses it."""

    @abstractmethod
    def _read_newest(self, request: Request[T]) -> T:
        """Return the newest answer to a request. V-REP streams the answers to such requests."""

    @abstractmethod
    def _send_command(self, request: Request[None]) -> None:
        """Send a command without waiting for its answer."""

    @property
    @abstractmethod
    def _header(self) -> Header:
        """The header of the newest reply."""

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self._execute(requests.object_handle(path))
        except RefusedError:
            return None
        return SceneObject(handle, path, self._kinds.get(handle, ObjectKind.OTHER))

    def list_objects(self) -> list[SceneObject]:
        """Return all objects with their names, because this API reports no paths."""
        group = self._execute(NAMES)
        return [
            SceneObject(handle, name, self._kinds.get(handle, ObjectKind.OTHER))
            for handle, name in zip(group.handles, group.texts, strict=False)
        ]

    def read_state(self) -> State:
        self._execute(requests.CLOCK)
        if not self._header.is_running:
            return State.STOPPED
        return State.PAUSED if self._header.is_paused else State.RUNNING

    def read_time_step(self) -> float:
        return self._execute(requests.float_parameter(TIME_STEP))

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._send_command(requests.joint_target_velocity(joint, rad_s))

    def read_joint_position(self, joint: int) -> float:
        return self._read_newest(requests.joint_position(joint))

    def detect(self, sensor: int) -> Point | None:
        reading = self._read_newest(requests.proximity(sensor))
        return _to_point(reading.point) if reading.is_detected else None

    def read_optics(self, sensor: int) -> CameraOptics:
        width, height = self._execute(picture_width(sensor)), self._execute(picture_height(sensor))
        return CameraOptics(width, height, compute_horizontal_fov(self._execute(view_angle(sensor)), width, height))

    def read_picture(self, sensor: int) -> RawPicture:
        pixels = self._read_newest(requests.colour_image(sensor))
        return RawPicture(pixels.data, pixels.shape[1], pixels.shape[0])

    def show(self, sensor: int, picture: RawPicture) -> None:
        self._send_command(requests.set_colour_image(sensor, bytes(picture.pixels)))

    def read_position(self, handle: int) -> Point:
        return _to_point(self._read_newest(requests.object_position(handle)))

    @cached_property
    def _kinds(self) -> dict[int, ObjectKind]:
        types = self._execute(TYPES)
        return {
            handle: KINDS.get(number, ObjectKind.OTHER)
            for handle, number in zip(types.handles, types.numbers, strict=False)
        }


def compute_velocity(before: Point, after: Point, seconds: float) -> Point:
    """Return the mean velocity between two positions, in m/s."""
    return _to_point([(end - start) / seconds for start, end in zip(before, after, strict=True)])


def _to_point(values: list[float] | tuple[float, ...]) -> Point:
    x, y, z = values
    return x, y, z


ALL_OBJECTS = 109
"""The number of the group of all objects of a scene, ``sim_appobj_object_type``."""

NAME_DATA, TYPE_DATA = 0, 1
"""The numbers that select the data of a group: names or types."""

RESOLUTION_X, RESOLUTION_Y, VIEW_ANGLE = 1002, 1003, 1004


class GroupData(NamedTuple):
    """The data of a group of objects: the handle of each object, and either an integer or a text for each object."""

    handles: tuple[int, ...]
    numbers: tuple[int, ...]
    """An integer for each object, such as its type; empty if texts were read."""
    texts: tuple[str, ...]
    """A text for each object, such as its name; empty if integers were read."""


def read_group(data: memoryview) -> GroupData:
    """Decode the data of a group of objects.

    The data has four counts, and then the counted handles, integers, floats and texts. The floats are ignored. The
    source of the layout is ``simxGetObjectGroupData`` in extApi.c of the simulator's maker.
    """
    handles, numbers, floats, texts = struct.unpack_from("<4i", data)
    if min(handles, numbers, floats, texts) < 0:
        raise ValueError("a negative count")
    whole = struct.unpack_from(f"<{handles + numbers}i", data, 16)
    rest = bytes(data[16 + 4 * (handles + numbers + floats) :])
    decoded = tuple(part.decode("utf-8", "replace") for part in rest.split(b"\0")[:texts])
    return GroupData(whole[:handles], whole[handles:], decoded)


NAMES: Request[GroupData] = pair_request("name the objects of the scene", 0x200C, ALL_OBJECTS, NAME_DATA, read_group)
TYPES: Request[GroupData] = pair_request(
    "read the types of the scene's objects", 0x200C, ALL_OBJECTS, TYPE_DATA, read_group
)


def picture_width(sensor: int) -> Request[int]:
    """Return a request that reads the width of a vision sensor's picture, in pixels."""
    return _parameter_request(sensor, 0x2008, RESOLUTION_X, read_int)


def picture_height(sensor: int) -> Request[int]:
    """Return a request that reads the height of a vision sensor's picture, in pixels."""
    return _parameter_request(sensor, 0x2008, RESOLUTION_Y, read_int)


def view_angle(sensor: int) -> Request[float]:
    """Return a request that reads the angle across the longer side of a vision sensor's picture, in rad."""
    return _parameter_request(sensor, 0x2007, VIEW_ANGLE, read_float)


def _parameter_request(sensor: int, command: int, number: int, decode: Any) -> Request[Any]:
    return pair_request("read a parameter of vision sensor", command, sensor, number, decode)

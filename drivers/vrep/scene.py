"""A scene behind the legacy remote API: what both ways of talking to it have in common."""

from __future__ import annotations

import math
from abc import abstractmethod
from functools import cached_property
from typing import TypeVar

from drivers.vrep import listing
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import RefusedError
from drivers.vrep.wire.messages import Header
from drivers.vrep.wire.request import Request
from robotcore.simulation.remote_scene import Kind, Lens, Point, RawPicture, Scene, SceneObject, State

T = TypeVar("T")

TIME_STEP = 1
"""A floating parameter: ``sim_floatparam_simulation_time_step``."""

STARTS = 3
"""So often is a simulation started whose time does not move: servers have been seen to need a second start."""

KINDS = {0: Kind.SHAPE, 1: Kind.JOINT, 5: Kind.PROXIMITY_SENSOR, 9: Kind.VISION_SENSOR}


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
        return SceneObject(handle, path, self._kinds.get(handle, Kind.OTHER))

    def objects(self) -> list[SceneObject]:
        """Return all objects under their names: this API does not tell their paths."""
        named = self._once(listing.NAMES)
        return [
            SceneObject(handle, name, self._kinds.get(handle, Kind.OTHER))
            for handle, name in zip(named.handles, named.texts, strict=False)
        ]

    def state(self) -> State:
        self._once(requests.CLOCK)
        if not self._server.is_running:
            return State.STOPPED
        return State.PAUSED if self._server.is_paused else State.RUNNING

    def time_step(self) -> float:
        return self._once(requests.float_parameter(TIME_STEP))

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._tell(requests.joint_target_velocity(joint, rad_s))

    def joint_position(self, joint: int) -> float:
        return self._newest(requests.joint_position(joint))

    def detected(self, sensor: int) -> Point | None:
        seen = self._newest(requests.proximity(sensor))
        return _point(seen.point) if seen.is_detected else None

    def lens(self, sensor: int) -> Lens:
        width, height = self._once(listing.columns(sensor)), self._once(listing.rows(sensor))
        return Lens(width, height, across(self._once(listing.view_angle(sensor)), width, height))

    def picture(self, sensor: int) -> RawPicture:
        pixels = self._newest(requests.colour_image(sensor))
        return RawPicture(pixels.data, pixels.shape[1], pixels.shape[0])

    def show(self, sensor: int, picture: RawPicture) -> None:
        self._tell(requests.set_colour_image(sensor, bytes(picture.pixels)))

    def position(self, handle: int) -> Point:
        return _point(self._newest(requests.object_position(handle)))

    @cached_property
    def _kinds(self) -> dict[int, Kind]:
        told = self._once(listing.TYPES)
        return {
            handle: KINDS.get(number, Kind.OTHER) for handle, number in zip(told.handles, told.numbers, strict=False)
        }


def across(longer: float, width: int, height: int) -> float:
    """Return the horizontal field of view of a picture whose longer side takes in that angle, in rad."""
    return longer if width >= height else 2 * math.atan(math.tan(longer / 2) * width / height)


def moved(before: Point, after: Point, seconds: float) -> Point:
    """Return the velocity of what has moved so in that time."""
    return _point([(there - here) / seconds for here, there in zip(before, after, strict=True)])


def _point(values: list[float] | tuple[float, ...]) -> Point:
    x, y, z = values
    return x, y, z

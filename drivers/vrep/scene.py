"""The scenes over the legacy remote API, in lockstep and without lockstep."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from functools import cached_property
from threading import Lock
from typing import Any, TypeVar

from drivers.vrep.connection import TIME_STANDS, Connection, TimedValue, build_halted_error
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import RefusedError, RemoteApiError, ServerTimeoutError, SimulationHaltedError
from drivers.vrep.wire.requests import Identity, Request
from robotcore.errors import BackendError
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

STARTS = 3
"""The number of attempts to start a simulation. On some servers, the time advances only after the second start."""

COPPELIASIM = 40000
"""The program's version from which on the plug-in for proximity sensors may be missing."""

FAR_M = (1000.0, 2000.0)
"""Two heights above the scene, in metres."""

KINDS = {0: ObjectKind.SHAPE, 1: ObjectKind.JOINT, 5: ObjectKind.PROXIMITY_SENSOR, 9: ObjectKind.VISION_SENSOR}


class LegacyScene(Scene):
    """A scene over the legacy remote API. The subclasses differ in how time advances, and how values are read."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    @abstractmethod
    def _try_start(self) -> None:
        """Start the simulation. Raises ServerTimeoutError or SimulationHaltedError if its time does not advance."""

    @abstractmethod
    def _read_newest(self, request: Request[T]) -> T:
        """Return the newest value of a request that the app reads repeatedly."""

    def start(self) -> None:
        """Start the simulation, and check that its time advances. If not, stop it and start it again."""
        self._start(STARTS)

    def _start(self, attempts: int) -> None:
        try:
            self._try_start()
        except (ServerTimeoutError, SimulationHaltedError):
            if attempts == 1 or self._connection.is_lost:
                raise
            self.stop()
            self._start(attempts - 1)

    def stop(self) -> None:
        self._connection.stop()

    def close(self) -> None:
        self._connection.close()

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self._connection.call(requests.object_handle(path))
        except RefusedError:
            return None
        return SceneObject(handle, path, self._kinds.get(handle, ObjectKind.OTHER))

    def list_objects(self) -> list[SceneObject]:
        """Return all objects with their names, because this API reports no paths."""
        group = self._connection.call(requests.OBJECT_NAMES)
        return [
            SceneObject(handle, name, self._kinds.get(handle, ObjectKind.OTHER))
            for handle, name in zip(group.handles, group.texts, strict=False)
        ]

    def read_state(self) -> State:
        self._connection.call(requests.CLOCK)
        server = self._connection.server
        if not server.is_running:
            return State.STOPPED
        return State.PAUSED if server.is_paused else State.RUNNING

    def read_time_step(self) -> float:
        return self._connection.call(requests.TIME_STEP)

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._connection.post(requests.joint_target_velocity(joint, rad_s))

    def read_joint_position(self, joint: int) -> float:
        return self._read_newest(requests.joint_position(joint))

    def detect(self, sensor: int) -> Point | None:
        reading = self._read_newest(requests.proximity(sensor))
        return _to_point(reading.point) if reading.is_detected else None

    def diagnose_sensor(self, sensor: int) -> str | None:
        """Return a sentence if the simulator cannot measure distances between objects.

        The same plug-in of CoppeliaSim measures these distances and simulates proximity sensors.
        """
        if self._can_measure:
            return None
        return (
            "this CoppeliaSim measures no distances between objects, so its proximity sensors detect nothing. Install "
            "a CoppeliaSim with the plug-in for proximity sensors; the maker's downloads have it"
        )

    def read_optics(self, sensor: int) -> CameraOptics:
        call = self._connection.call
        width, height = call(requests.picture_width(sensor)), call(requests.picture_height(sensor))
        angle = call(requests.view_angle(sensor))
        return CameraOptics(width, height, compute_horizontal_fov(angle, width, height))

    def read_picture(self, sensor: int) -> RawPicture:
        pixels = self._read_newest(requests.colour_image(sensor))
        return RawPicture(pixels.data, pixels.shape[1], pixels.shape[0])

    def show(self, sensor: int, picture: RawPicture) -> None:
        self._connection.post(requests.set_colour_image(sensor, bytes(picture.pixels)))

    def read_position(self, handle: int) -> Point:
        return _to_point(self._read_newest(requests.object_position(handle)))

    @cached_property
    def _can_measure(self) -> bool:
        """Whether the distance between a shape and a dummy grows as the dummy moves away.

        Without the plug-in, a server answers with a random number. If it refuses a request, the result is True.
        """
        call = self._connection.call
        shape = next((handle for handle, kind in self._kinds.items() if kind is ObjectKind.SHAPE), None)
        if shape is None or call(requests.CLOCK) < COPPELIASIM:
            return True
        try:
            dummy = call(requests.CREATE_DUMMY)
        except RefusedError:
            return True
        try:
            near, far = (self._measure(shape, dummy, height) for height in FAR_M)
        except RefusedError:
            return True
        finally:
            call(requests.remove_object(dummy))
        return math.isclose(far - near, FAR_M[1] - FAR_M[0], rel_tol=0.1)

    def _measure(self, shape: int, dummy: int, height: float) -> float:
        self._connection.call(requests.set_object_position(dummy, 0.0, 0.0, height))
        return self._connection.call(requests.distance(shape, dummy))

    @cached_property
    def _kinds(self) -> dict[int, ObjectKind]:
        types = self._connection.call(requests.OBJECT_TYPES)
        return {
            handle: KINDS.get(number, ObjectKind.OTHER)
            for handle, number in zip(types.handles, types.numbers, strict=False)
        }


class SteppedScene(LegacyScene):
    """A scene in lockstep.

    `advance` triggers the time step, and requests again all values that the app has read since the previous step. So
    the app's next reads need no further round trips. Once the app has read a position, each later step requests it,
    because velocities are computed from positions.
    """

    def __init__(self, connection: Connection) -> None:
        super().__init__(connection)
        self._values: dict[Identity, Any] = {}
        self._requested: dict[Identity, Request[Any]] = {}
        self._positions: dict[int, Point] = {}
        self._step_s = 0.0

    def start(self) -> None:
        super().start()
        self._step_s = self.read_time_step()

    def read_time(self) -> float:
        return self._connection.time_s

    def advance(self, steps: int) -> None:
        for left in range(steps - 1, -1, -1):
            positions = {handle: requests.object_position(handle) for handle in self._positions}
            self._positions.update({handle: self.read_position(handle) for handle in positions})
            reads = {read.identity: read for read in positions.values()}
            if left == 0:
                reads |= self._requested
                self._requested = {}
            values = self._connection.step(*reads.values())
            self._values = dict(zip(reads, values, strict=True))

    def read_position(self, handle: int) -> Point:
        position = super().read_position(handle)
        self._positions.setdefault(handle, position)
        return position

    def read_velocity(self, handle: int) -> Point:
        return _compute_velocity(self._positions[handle], self.read_position(handle), self._step_s)

    def close(self) -> None:
        """End lockstep, so that the simulation runs without triggers, and disconnect."""
        try:
            self._connection.wait_for_triggers(wait=False)
        except RemoteApiError:
            pass  # the server has ended, or the connection is closed
        finally:
            super().close()

    def _try_start(self) -> None:
        self._connection.wait_for_triggers(wait=True)
        self._connection.start()
        self._connection.step()

    def _read_newest(self, request: Request[T]) -> T:
        self._requested[request.identity] = request
        if request.identity not in self._values:
            self._values[request.identity] = self._connection.call(request)
        value: T = self._values[request.identity]
        return value


class StreamedScene(LegacyScene):
    """A scene without lockstep. The server streams values after each time step, so reads do not wait."""

    def __init__(self, connection: Connection) -> None:
        super().__init__(connection)
        self._time_lock, self._last_time_s = Lock(), 0.0

    def stop(self) -> None:
        super().stop()
        self._last_time_s = 0.0

    def read_time(self) -> float:
        """Return the newest time of the simulation in seconds.

        Raises SimulationHaltedError if the simulation is paused or stopped, or was restarted since the previous read.
        """
        self._connection.require_running()
        with self._time_lock:
            time_s = self._connection.read_newest(requests.CLOCK).time_s
            if time_s < self._last_time_s:
                raise build_halted_error("stopped")
            self._last_time_s = time_s
        return time_s

    def advance(self, steps: int) -> None:
        """Raise BackendError, because only a simulation in lockstep can be advanced."""
        raise BackendError("a simulation without lockstep cannot be advanced by steps", kind="not-stepped")

    def read_velocity(self, handle: int) -> Point:
        """Return the mean velocity between the newest position and the next one, in m/s."""
        before, after = self._await_next(requests.object_position(handle))
        return _compute_velocity(before.value, after.value, after.time_s - before.time_s)

    def _try_start(self) -> None:
        self._connection.call(requests.START)
        self._await_next(requests.CLOCK)

    def _await_next(self, request: Request[Any]) -> tuple[TimedValue, TimedValue]:
        """Return the newest value of a request, and the value after the next time step."""
        before = self._connection.read_newest(request)
        self._connection.await_condition(
            lambda: self._connection.read_newest(request).time_s != before.time_s, TIME_STANDS
        )
        return before, self._connection.read_newest(request)

    def _read_newest(self, request: Request[T]) -> T:
        value: T = self._connection.read_newest(request).value
        return value


def _compute_velocity(before: Sequence[float], after: Sequence[float], seconds: float) -> Point:
    return _to_point([(end - start) / seconds for start, end in zip(before, after, strict=True)])


def _to_point(values: Sequence[float]) -> Point:
    x, y, z = values
    return x, y, z

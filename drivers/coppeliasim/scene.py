"""A scene behind the ZeroMQ remote API, in lockstep."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from drivers.coppeliasim.connection import LOADING_S, Connection, RefusedError
from drivers.coppeliasim.lease import Lease
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
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

_SAME_S = 1e-6
_PAUSED, _ADVANCING = 8, 16
"""Bits of a simulation's state."""

_STOPPING = (21, 22)
"""The states of its last steps: ``simulation_advancing_abouttostop`` and ``simulation_advancing_lastbeforestop``."""

_STOPPING_S, _NAP_S = 0.5, 0.01
"""Such a stop is waited for so long, and looked at so often."""

Probe = Callable[[Callable[[int], Point | None]], bool]
"""Return whether proximity sensors work. The argument returns the point that the sensor with this handle detects."""

_LOOK = "Look into its window or its log for what it says"


class CoppeliaSimScene(Scene):
    """A scene that is asked call by call.

    ``close`` gives the ``lease`` back. Without a ``probe`` every proximity sensor counts as reliable.
    """

    def __init__(self, connection: Connection, lease: Lease | None = None, probe: Probe | None = None) -> None:
        self.connection = connection
        self._lease, self._probe = lease, probe
        self._kinds = {
            connection.constant("object_joint_type"): ObjectKind.JOINT,
            connection.constant("object_proximitysensor_type"): ObjectKind.PROXIMITY_SENSOR,
            connection.constant("object_visionsensor_type"): ObjectKind.VISION_SENSOR,
            connection.constant("object_shape_type"): ObjectKind.SHAPE,
        }
        self._explicit: dict[int, bool] = {}
        self._step_s = self._time = 0.0
        self._limit_s: float | None = None

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self.connection.call_as(int, "getObject", path, {"noError": True})
        except RefusedError:  # of an old name that is no path
            handle = self._find_flat(path)
        return self._object(handle) if handle >= 0 else None

    def list_objects(self) -> Sequence[SceneObject]:
        handles = self.connection.call_as(list, "getObjectsInTree", self.connection.constant("handle_scene"))
        return [self._object(handle) for handle in handles]

    def read_state(self) -> State:
        """Return what the simulation does; a stop that is under way is waited for."""
        wall = MonotonicClock()
        while (state := self.connection.call_as(int, "getSimulationState")) in _STOPPING and wall.now() < _STOPPING_S:
            wall.sleep_until(wall.now() + _NAP_S)
        if state & _ADVANCING:
            return State.RUNNING
        return State.PAUSED if state & _PAUSED else State.STOPPED

    def start(self) -> None:
        before = self.read_state()
        self.connection.sim("setStepping", True)  # lost at every stop
        if before is not State.RUNNING:
            self.connection.sim("startSimulation", within_s=LOADING_S)
        if self.read_state() is not State.RUNNING:
            raise BackendError(f"coppeliasim: the simulation at {self.connection.address} does not start. {_LOOK}")
        self._step_s, self._time, self._limit_s = self.read_time_step(), self.read_time(), LOADING_S

    def stop(self) -> None:
        if self._lease:
            self._lease.require()
        if self.read_state() is State.STOPPED:
            return
        self.connection.sim("stopSimulation", True, within_s=LOADING_S)
        if (state := self.read_state()) is not State.STOPPED:
            raise BackendError(f"coppeliasim: the simulation was told to stop and is {state.value}. Stop it by hand")

    def read_time_step(self) -> float:
        return self.connection.call_as(float, "getSimulationTimeStep")

    def read_time(self) -> float:
        return self.connection.call_as(float, "getSimulationTime")

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            self.connection.sim("step", within_s=self._limit_s)
            self._limit_s = None  # the first step of all may take its time
        now = self.read_time()
        if not math.isclose(now - self._time, steps * self._step_s, rel_tol=_SAME_S, abs_tol=_SAME_S):
            raise self._out_of_step(now - self._time, steps)
        self._time = now

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self.connection.sim("setJointTargetVelocity", joint, rad_s)

    def read_joint_position(self, joint: int) -> float:
        return self.connection.call_as(float, "getJointPosition", joint)

    def detect(self, sensor: int) -> Point | None:
        name = "handleProximitySensor" if self._is_explicit(sensor) else "readProximitySensor"
        return self.connection.call_as(_detected_point, name, sensor)

    def diagnose_sensor(self, sensor: int) -> str | None:
        if self._probe is None or self._probe(self.detect):
            return None
        return (
            f"the CoppeliaSim at {self.connection.address} does not detect a box in front of a proximity sensor, so "
            "that every way seems free. Take one with the plug-in for them, as the maker's downloads are"
        )

    def read_optics(self, sensor: int) -> CameraOptics:
        width, height = self.connection.call_as(_size, "getVisionSensorRes", sensor)
        is_perspective = self.connection.call_as(
            int, "getObjectInt32Param", sensor, self.connection.constant("visionintparam_perspective_operation")
        )
        if not is_perspective:
            return CameraOptics(width, height, None)
        wide = self.connection.call_as(
            float, "getObjectFloatParam", sensor, self.connection.constant("visionfloatparam_perspective_angle")
        )
        return CameraOptics(width, height, compute_horizontal_fov(wide, width, height))

    def read_picture(self, sensor: int) -> RawPicture:
        """Return what it sees now, if it is handled explicitly; else what it saw at the end of the last step."""
        return self.connection.run_batch(partial(self._seen, sensor))

    def show(self, sensor: int, picture: RawPicture) -> None:
        self.connection.sim("setVisionSensorImg", sensor, picture.pixels)

    def read_position(self, handle: int) -> Point:
        return self.connection.call_as(_point, "getObjectPosition", handle)

    def read_velocity(self, handle: int) -> Point:
        return self.connection.call_as(_linear, "getObjectVelocity", handle)

    def close(self) -> None:
        try:
            if self._lease:
                self._lease.release()
        finally:
            self.connection.close()

    def _seen(self, sensor: int) -> RawPicture:
        if self._is_explicit(sensor):
            self.connection.sim("handleVisionSensor", sensor)
        return self.connection.call_as(_raw_picture, "getVisionSensorImg", sensor)

    def _find_flat(self, name: str) -> int:
        try:
            return self.connection.call_as(int, "getObjectHandle", name)
        except RefusedError:
            return -1

    def _object(self, handle: int) -> SceneObject:
        number = self.connection.call_as(int, "getObjectType", handle)
        path = self.connection.call_as(str, "getObjectAlias", handle, 1)
        return SceneObject(handle, path, self._kinds.get(number, ObjectKind.OTHER))

    def _is_explicit(self, sensor: int) -> bool:
        if sensor not in self._explicit:
            self._explicit[sensor] = bool(self.connection.call_as(int, "getExplicitHandling", sensor))
        return self._explicit[sensor]

    def _out_of_step(self, passed: float, steps: int) -> BackendError:
        """Return what is to be said where steps took another time than theirs."""
        if self._lease:
            self._lease.require()
        state = self.read_state()
        if state is State.STOPPED:
            what = "was stopped by somebody else. Run again, and leave it to this program"
        elif state is State.PAUSED:
            what = "was paused by somebody else. Let it go on, and run again"
        else:
            what = (
                f"went on by {passed:g} s in {steps} step(s) of {self._step_s:g} s: it is no longer in lockstep. "
                "Another program may step it too, or this one was silent for so long that CoppeliaSim forgot it"
            )
        return BackendError(f"coppeliasim: the simulation at {self.connection.address} {what}")


def _point(answer: Any) -> Point:
    x, y, z = answer
    return float(x), float(y), float(z)


def _linear(answer: Any) -> Point:
    linear, _ = answer
    return _point(linear)


def _size(answer: Any) -> tuple[int, int]:
    width, height = answer
    return int(width), int(height)


def _detected_point(answer: Any) -> Point | None:
    """Return the point of a proximity sensor's result; where it detects nothing, all but the first is rubbish."""
    if isinstance(answer, int):
        return None
    return _point(answer[2]) if answer[0] == 1 else None


def _raw_picture(answer: Any) -> RawPicture:
    pixels, *size = answer  # the size is one list, and was two numbers before 4.4
    width, height = _size(size[0] if len(size) == 1 else size)
    if not isinstance(pixels, bytes) or len(pixels) != 3 * width * height:
        raise ValueError(f"{width} x {height} pixels")
    return RawPicture(pixels, width, height)

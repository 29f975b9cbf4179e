"""A scene of CoppeliaSim that runs in lockstep over the ZeroMQ remote API."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Any

from drivers.coppeliasim.address import RefusedError, build_error
from drivers.coppeliasim.connection import LOADING_S, SimulatorConnection
from drivers.coppeliasim.simulator_lock import SimulatorLock
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

_TOLERANCE_S = 1e-6
_PAUSED, _ADVANCING = 8, 16
"""Bits of the number by which CoppeliaSim reports the state of the simulation."""

_STOPPING = (21, 22)
"""The states ``simulation_advancing_abouttostop`` and ``simulation_advancing_lastbeforestop``."""

_STOPPING_S, _NAP_S = 0.5, 0.01
"""Time limit until a simulation in a state of `_STOPPING` has stopped, and the time between two reads, in seconds."""

Probe = Callable[[Callable[[int], Point | None]], bool]
"""A function that returns whether proximity sensors work. Its argument is `CoppeliaSimScene.detect`."""


class CoppeliaSimScene(Scene):
    """A scene of CoppeliaSim. Each method makes one or a few calls of the remote API.

    lock: the lock of the simulator, which `close` releases; None for a scene that is only inspected.
    probe: returns whether proximity sensors work; None if all proximity sensors are known to work.
    """

    def __init__(
        self, connection: SimulatorConnection, lock: SimulatorLock | None = None, probe: Probe | None = None
    ) -> None:
        self.connection = connection
        self._lock, self._probe = lock, probe
        self._kinds = {
            connection.constant("object_joint_type"): ObjectKind.JOINT,
            connection.constant("object_proximitysensor_type"): ObjectKind.PROXIMITY_SENSOR,
            connection.constant("object_visionsensor_type"): ObjectKind.VISION_SENSOR,
            connection.constant("object_shape_type"): ObjectKind.SHAPE,
        }
        self._explicit: dict[int, bool] = {}
        self._joints: set[int] = set()
        self._step_s = self._time = 0.0
        self._limit_s: float | None = None

    def __repr__(self) -> str:
        return f"<CoppeliaSimScene, {self.connection!r}>"

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self.connection.call_as(int, "getObject", path, {"noError": True})
        except RefusedError:  # a name of an old scene is no path
            handle = self._find_by_old_name(path)
        return self._read_object(handle) if handle >= 0 else None

    def list_objects(self) -> Sequence[SceneObject]:
        handles = self.connection.call_as(list, "getObjectsInTree", self.connection.constant("handle_scene"))
        return [self._read_object(handle) for handle in handles]

    def read_state(self) -> State:
        """Return the state of the simulation. If the simulation is about to stop, wait until it has stopped."""
        wall = MonotonicClock()
        while (state := self.connection.call_as(int, "getSimulationState")) in _STOPPING and wall.now() < _STOPPING_S:
            wall.sleep_until(wall.now() + _NAP_S)
        if state & _ADVANCING:
            return State.RUNNING
        return State.PAUSED if state & _PAUSED else State.STOPPED

    def start(self) -> None:
        before = self.read_state()
        self.connection.sim("setStepping", True)  # each stop resets it
        if before is not State.RUNNING:
            self.connection.sim("startSimulation", within_s=LOADING_S)
        if self.read_state() is not State.RUNNING:
            raise build_error(
                self.connection.address,
                "simulation-not-started",
                f"the simulation at {self.connection.address} does not start. Read CoppeliaSim's message in its window "
                "or its log",
            )
        self._step_s, self._time, self._limit_s = self.read_time_step(), self.read_time(), LOADING_S

    def stop(self) -> None:
        """Stop the simulation. If the simulator has ended or hangs, this does nothing."""
        if self.connection.is_lost:
            return
        if self._lock:
            self._lock.require_ownership()
        if self.read_state() is State.STOPPED:
            return
        self.connection.sim("stopSimulation", True, within_s=LOADING_S)
        if (state := self.read_state()) is not State.STOPPED:
            raise build_error(
                self.connection.address,
                "simulation-not-stopped",
                f"the simulation does not stop; it is {state.value}. Stop it in CoppeliaSim",
                state=state.value,
            )

    def read_time_step(self) -> float:
        return self.connection.call_as(float, "getSimulationTimeStep")

    def read_time(self) -> float:
        return self.connection.call_as(float, "getSimulationTime")

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            self.connection.sim("step", within_s=self._limit_s)
            self._limit_s = None  # only the first step loads
        now = self.read_time()
        if not math.isclose(now - self._time, steps * self._step_s, rel_tol=_TOLERANCE_S, abs_tol=_TOLERANCE_S):
            raise self._build_lockstep_error(now - self._time, steps)
        self._time = now

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._joints.add(joint)
        self.connection.sim("setJointTargetVelocity", joint, rad_s)

    def read_joint_position(self, joint: int) -> float:
        return self.connection.call_as(float, "getJointPosition", joint)

    def detect(self, sensor: int) -> Point | None:
        name = "handleProximitySensor" if self._is_explicit(sensor) else "readProximitySensor"
        return self.connection.call_as(_to_detection, name, sensor)

    def diagnose_sensor(self, sensor: int) -> str | None:
        if self._probe is None or self._probe(self.detect):
            return None
        return (
            f"the CoppeliaSim at {self.connection.address} does not detect a box in front of a proximity sensor, so "
            "the robot would detect no obstacles. Install a CoppeliaSim with the plug-in for proximity sensors; the "
            "maker's downloads have it"
        )

    def read_optics(self, sensor: int) -> CameraOptics:
        width, height = self.connection.call_as(_to_size, "getVisionSensorRes", sensor)
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
        """Return the picture of a vision sensor.

        If the option explicit handling is set for the sensor, this call renders the picture. Otherwise the simulator
        has rendered it in the last time step.
        """
        return self.connection.run_batch(partial(self._render_picture, sensor))

    def show(self, sensor: int, picture: RawPicture) -> None:
        self.connection.sim("setVisionSensorImg", sensor, picture.pixels)

    def read_position(self, handle: int) -> Point:
        return self.connection.call_as(_to_point, "getObjectPosition", handle)

    def read_velocity(self, handle: int) -> Point:
        return self.connection.call_as(_to_linear, "getObjectVelocity", handle)

    def close(self) -> None:
        """Release the lock, and disconnect. If the server is frozen, its wheels stop once it continues."""
        with ExitStack() as steps:
            steps.callback(self.connection.close)
            if self._lock:
                steps.callback(self._lock.release)
            for joint in self._joints:
                self.connection.queue("setJointTargetVelocity", joint, 0.0)

    def _render_picture(self, sensor: int) -> RawPicture:
        if self._is_explicit(sensor):
            self.connection.sim("handleVisionSensor", sensor)
        return self.connection.call_as(_to_raw_picture, "getVisionSensorImg", sensor)

    def _find_by_old_name(self, name: str) -> int:
        try:
            return self.connection.call_as(int, "getObjectHandle", name)
        except RefusedError:
            return -1

    def _read_object(self, handle: int) -> SceneObject:
        number = self.connection.call_as(int, "getObjectType", handle)
        path = self.connection.call_as(str, "getObjectAlias", handle, 1)
        return SceneObject(handle, path, self._kinds.get(number, ObjectKind.OTHER))

    def _is_explicit(self, sensor: int) -> bool:
        if sensor not in self._explicit:
            self._explicit[sensor] = bool(self.connection.call_as(int, "getExplicitHandling", sensor))
        return self._explicit[sensor]

    def _build_lockstep_error(self, passed: float, steps: int) -> BackendError:
        """Return the error for a simulation whose time has not advanced by the requested time steps.

        passed: the time in seconds by which the simulation has advanced.
        steps: the requested number of time steps.
        """
        if self._lock:
            self._lock.require_ownership()
        state = self.read_state()
        if state is State.STOPPED:
            kind, problem = "simulation-stopped", "was stopped during the run. Run again"
        elif state is State.PAUSED:
            kind, problem = "simulation-paused", "was paused during the run. Resume it in CoppeliaSim, and run again"
        else:
            kind = "lockstep-lost"
            problem = (
                f"advanced by {passed:g} s in {steps} step(s) of {self._step_s:g} s, so it is no longer in lockstep. "
                "Check whether another program steps this simulation, or whether this program was suspended for more "
                "than 5 s"
            )
        address = self.connection.address
        return build_error(address, kind, f"the simulation at {address} {problem}")


def _to_point(answer: Any) -> Point:
    x, y, z = answer
    return float(x), float(y), float(z)


def _to_linear(answer: Any) -> Point:
    linear, _ = answer
    return _to_point(linear)


def _to_size(answer: Any) -> tuple[int, int]:
    width, height = answer
    return int(width), int(height)


def _to_detection(answer: Any) -> Point | None:
    if isinstance(answer, int):
        return None
    return _to_point(answer[2]) if answer[0] == 1 else None


def _to_raw_picture(answer: Any) -> RawPicture:
    pixels, size = answer
    width, height = _to_size(size)
    if not isinstance(pixels, bytes) or len(pixels) != 3 * width * height:
        raise ValueError(f"{width} x {height} pixels")
    return RawPicture(pixels, width, height)

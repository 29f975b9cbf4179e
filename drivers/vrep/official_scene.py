"""A scene over the official binding, for users who want to keep what they have."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property

import numpy as np

from drivers.vrep.official_binding import Calls
from drivers.vrep.scene import (
    EVERYTHING,
    KINDS,
    NAMES_OF,
    RESOLUTION_X,
    RESOLUTION_Y,
    STARTS,
    TIME_STEP,
    VIEW_ANGLE,
    velocity_between,
)
from drivers.vrep.wire.errors import RefusedError, RemoteApiError, ServerHangsError, SimulationHaltedError
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

_RUNNING, _PAUSED = 1, 2
_NAP_S = 0.005


class OfficialScene(Scene):
    """Streams what is read again and again; how many round trips that takes is the binding's affair."""

    def __init__(self, calls: Calls, answer_s: float, *, is_stepped: bool) -> None:
        self._calls, self._answer_s, self._is_stepped = calls, answer_s, is_stepped
        self._wall = MonotonicClock()
        self._before: dict[int, Point] = {}

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self._calls.once("simxGetObjectHandle", path)
        except RefusedError:
            return None
        return SceneObject(handle, path, self._kinds.get(handle, ObjectKind.OTHER))

    def list_objects(self) -> list[SceneObject]:
        """Return all objects under their names; none where the binding has no function for it."""
        if not hasattr(self._calls.api, "simxGetObjectGroupData"):
            return []
        handles, _, _, names = self._calls.once("simxGetObjectGroupData", EVERYTHING, NAMES_OF)
        named = zip(handles, names, strict=False)
        return [SceneObject(handle, name, self._kinds.get(handle, ObjectKind.OTHER)) for handle, name in named]

    def read_state(self) -> State:
        server_state = self._calls.server_state
        if not server_state & _RUNNING:
            return State.STOPPED
        return State.PAUSED if server_state & _PAUSED else State.RUNNING

    def start(self) -> None:
        for left in range(STARTS - 1, -1, -1):
            if self._is_stepped:
                self._calls.run("simxSynchronous", True)
            self._calls.once("simxStartSimulation")
            if self._comes_to_move():
                return
            if left:
                self.stop()
        raise ServerHangsError("the simulation was started, and its time does not move. Stop it there, and run again")

    def stop(self) -> None:
        self._calls.once("simxStopSimulation")
        if not self._comes(lambda: self.read_state() is State.STOPPED):
            raise ServerHangsError(f"the simulation has not stopped within {self._answer_s:g} s. Restart the simulator")

    def read_time_step(self) -> float:
        return float(self._calls.once(self._calls.named("simxGetFloatParam", "simxGetFloatingParameter"), TIME_STEP))

    def read_time(self) -> float:
        return self._calls.time_s

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            self._before = {handle: self.read_position(handle) for handle in self._before}
            if not self._steps():
                raise SimulationHaltedError(
                    f"the simulation was {self.read_state().value}: no step can be taken. Run again"
                )

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._calls.send("simxSetJointTargetVelocity", joint, rad_s)

    def read_joint_position(self, joint: int) -> float:
        return float(self._calls.read("simxGetJointPosition", joint))

    def detect(self, sensor: int) -> Point | None:
        is_detected, (x, y, z), *_ = self._calls.read("simxReadProximitySensor", sensor)
        return (x, y, z) if is_detected else None

    def read_optics(self, sensor: int) -> CameraOptics:
        whole = self._calls.named("simxGetObjectInt32Param", "simxGetObjectIntParameter")
        width, height = (int(self._calls.once(whole, sensor, number)) for number in (RESOLUTION_X, RESOLUTION_Y))
        fraction = self._calls.named("simxGetObjectFloatParam", "simxGetObjectFloatParameter")
        return CameraOptics(
            width, height, compute_horizontal_fov(self._calls.once(fraction, sensor, VIEW_ANGLE), width, height)
        )

    def read_picture(self, sensor: int) -> RawPicture:
        (width, height), pixels = self._calls.read("simxGetVisionSensorImage", sensor, 0)
        return RawPicture(np.array(pixels, np.int8).tobytes(), width, height)

    def show(self, sensor: int, picture: RawPicture) -> None:
        self._calls.send("simxSetVisionSensorImage", sensor, list(bytes(picture.pixels)), 0)

    def read_position(self, handle: int) -> Point:
        x, y, z = self._calls.read("simxGetObjectPosition", handle, -1)
        self._before.setdefault(handle, (x, y, z))
        return x, y, z

    def read_velocity(self, handle: int) -> Point:
        """Return how it moved in the last step; where time is followed, from now to the next step."""
        if self._is_stepped:
            return velocity_between(self._before[handle], self.read_position(handle), self.read_time_step())
        before, begun = self.read_position(handle), self.read_time()
        if not self._comes(lambda: self.read_time() != begun):
            raise ServerHangsError(f"the simulation's time has not moved within {self._answer_s:g} s")
        return velocity_between(before, self.read_position(handle), self.read_time() - begun)

    def close(self) -> None:
        """Let a simulation that goes on without us go on by itself, and leave."""
        if self._is_stepped:
            with suppress(RemoteApiError):
                self._calls.run("simxSynchronous", False)
        self._calls.close()

    @cached_property
    def _kinds(self) -> dict[int, ObjectKind]:
        return {handle: kind for number, kind in KINDS.items() for handle in self._calls.once("simxGetObjects", number)}

    def _comes_to_move(self) -> bool:
        if self._is_stepped:
            return self._steps()
        begun = self.read_time()
        return self._comes(lambda: self.read_time() != begun)

    def _steps(self) -> bool:
        """Trigger a step; return whether time has moved by it."""
        begun = self.read_time()
        try:
            self._calls.run("simxSynchronousTrigger")
        except RefusedError:
            return False
        self._calls.run("simxGetPingTime")
        return self._comes(lambda: self.read_time() != begun)

    def _comes(self, is_so: Callable[[], bool]) -> bool:
        """Wait until it is so; return whether it came to be."""
        deadline = self._wall.now() + self._answer_s
        while not (came := is_so()) and self._wall.now() < deadline:
            self._wall.sleep_until(self._wall.now() + _NAP_S)
        return came

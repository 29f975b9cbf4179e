"""A scene that is accessed through the simulator's official Python binding."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property

import numpy as np

from drivers.vrep.official_binding import OfficialClient
from drivers.vrep.scene import (
    ALL_OBJECTS,
    KINDS,
    NAME_DATA,
    RESOLUTION_X,
    RESOLUTION_Y,
    STARTS,
    TIME_STEP,
    VIEW_ANGLE,
    compute_velocity,
)
from drivers.vrep.wire.errors import RefusedError, RemoteApiError, ServerTimeoutError, SimulationHaltedError
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
    """A scene that is accessed through the official binding. The server streams the values that the app reads.

    client: the client of the binding.
    answer_s: time limit of starting and stopping the simulation, in seconds.
    is_stepped: whether the simulation waits for a trigger before each time step.
    """

    def __init__(self, client: OfficialClient, answer_s: float, *, is_stepped: bool) -> None:
        self._client, self._answer_s, self._is_stepped = client, answer_s, is_stepped
        self._wall = MonotonicClock()
        self._positions: dict[int, Point] = {}

    def find(self, path: str) -> SceneObject | None:
        try:
            handle = self._client.call_blocking("simxGetObjectHandle", path)
        except RefusedError:
            return None
        return SceneObject(handle, path, self._kinds.get(handle, ObjectKind.OTHER))

    def list_objects(self) -> list[SceneObject]:
        """Return all objects with their names. The result is empty if the binding has no function that lists them."""
        if not hasattr(self._client.api, "simxGetObjectGroupData"):
            return []
        handles, _, _, names = self._client.call_blocking("simxGetObjectGroupData", ALL_OBJECTS, NAME_DATA)
        pairs = zip(handles, names, strict=False)
        return [SceneObject(handle, name, self._kinds.get(handle, ObjectKind.OTHER)) for handle, name in pairs]

    def read_state(self) -> State:
        server_state = self._client.server_state
        if not server_state & _RUNNING:
            return State.STOPPED
        return State.PAUSED if server_state & _PAUSED else State.RUNNING

    def start(self) -> None:
        for left in range(STARTS - 1, -1, -1):
            if self._is_stepped:
                self._client.call("simxSynchronous", True)
            self._client.call_blocking("simxStartSimulation")
            if self._does_time_advance():
                return
            if left:
                self.stop()
        raise ServerTimeoutError(
            "the simulation was started, but its time does not advance. Stop it in the simulator, and run again"
        )

    def stop(self) -> None:
        self._client.call_blocking("simxStopSimulation")
        if not self._wait_until(lambda: self.read_state() is State.STOPPED):
            raise ServerTimeoutError(
                f"the simulation has not stopped within {self._answer_s:g} s. Restart the simulator"
            )

    def read_time_step(self) -> float:
        return float(
            self._client.call_blocking(
                self._client.find_name("simxGetFloatParam", "simxGetFloatingParameter"), TIME_STEP
            )
        )

    def read_time(self) -> float:
        return self._client.time_s

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            self._positions = {handle: self.read_position(handle) for handle in self._positions}
            if not self._step_and_check_time():
                state = self.read_state().value
                raise SimulationHaltedError(
                    f"the simulation was {state}, so its time does not advance. Run again", kind=f"simulation-{state}"
                )

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        self._client.send("simxSetJointTargetVelocity", joint, rad_s)

    def read_joint_position(self, joint: int) -> float:
        return float(self._client.read_stream("simxGetJointPosition", joint))

    def detect(self, sensor: int) -> Point | None:
        is_detected, (x, y, z), *_ = self._client.read_stream("simxReadProximitySensor", sensor)
        return (x, y, z) if is_detected else None

    def read_optics(self, sensor: int) -> CameraOptics:
        whole = self._client.find_name("simxGetObjectInt32Param", "simxGetObjectIntParameter")
        width, height = (
            int(self._client.call_blocking(whole, sensor, number)) for number in (RESOLUTION_X, RESOLUTION_Y)
        )
        fraction = self._client.find_name("simxGetObjectFloatParam", "simxGetObjectFloatParameter")
        return CameraOptics(
            width,
            height,
            compute_horizontal_fov(self._client.call_blocking(fraction, sensor, VIEW_ANGLE), width, height),
        )

    def read_picture(self, sensor: int) -> RawPicture:
        (width, height), pixels = self._client.read_stream("simxGetVisionSensorImage", sensor, 0)
        return RawPicture(np.array(pixels, np.int8).tobytes(), width, height)

    def show(self, sensor: int, picture: RawPicture) -> None:
        self._client.send("simxSetVisionSensorImage", sensor, list(bytes(picture.pixels)), 0)

    def read_position(self, handle: int) -> Point:
        x, y, z = self._client.read_stream("simxGetObjectPosition", handle, -1)
        self._positions.setdefault(handle, (x, y, z))
        return x, y, z

    def read_velocity(self, handle: int) -> Point:
        """Return the mean velocity over the last time step, or without lockstep over the next one, in m/s."""
        if self._is_stepped:
            return compute_velocity(self._positions[handle], self.read_position(handle), self.read_time_step())
        before, start_s = self.read_position(handle), self.read_time()
        if not self._wait_until(lambda: self.read_time() != start_s):
            raise ServerTimeoutError(f"the simulation's time has not advanced within {self._answer_s:g} s")
        return compute_velocity(before, self.read_position(handle), self.read_time() - start_s)

    def close(self) -> None:
        """End lockstep, so that the simulation runs without triggers, and disconnect."""
        if self._is_stepped:
            with suppress(RemoteApiError):
                self._client.call("simxSynchronous", False)
        self._client.close()

    @cached_property
    def _kinds(self) -> dict[int, ObjectKind]:
        return {
            handle: kind
            for number, kind in KINDS.items()
            for handle in self._client.call_blocking("simxGetObjects", number)
        }

    def _does_time_advance(self) -> bool:
        if self._is_stepped:
            return self._step_and_check_time()
        start_s = self.read_time()
        return self._wait_until(lambda: self.read_time() != start_s)

    def _step_and_check_time(self) -> bool:
        start_s = self.read_time()
        try:
            self._client.call("simxSynchronousTrigger")
        except RefusedError:
            return False
        self._client.call("simxGetPingTime")
        return self._wait_until(lambda: self.read_time() != start_s)

    def _wait_until(self, condition: Callable[[], bool]) -> bool:
        deadline = self._wall.now() + self._answer_s
        while not (is_true := condition()) and self._wall.now() < deadline:
            self._wall.sleep_until(self._wall.now() + _NAP_S)
        return is_true

"""The physics steps of MuJoCo, and the robot's body, contacts and true state."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotcore.description import RobotDescription
from robotcore.description.urdf import BASE, wheel_joint
from robotcore.errors import BackendError, DeviceError
from robotcore.geometry import Pose, Twist
from robotcore.hal.clock import SteppedClock
from robotcore.hal.truth import RELEASE_M

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class Physics:
    """The physics of a simulation: a stepped clock whose steps are physics steps of MuJoCo.

    A step of MuJoCo has two halves: `mj_step1` computes the contacts of the current positions, and `mj_step2` computes
    the next positions. After both, the contacts would be one step older than the positions. So each step of this class
    calls `mj_step2` and then `mj_step1`, and all of `data` belongs to the same time.
    """

    def __init__(self, rate_hz: float, build_model: Callable[[float], MjModel]) -> None:
        """Build the model and its first state.

        rate_hz: the rate of ticks, in Hz.
        build_model: a function that returns the model for a length of the physics step in seconds.
        """
        from mujoco import MjData, mj_step1, mj_step2

        self.clock = SteppedClock(rate_hz, self._advance)
        self.model = build_model(self.clock.step)
        self.data = MjData(self.model)
        self._finish_step, self._begin_step = mj_step2, mj_step1
        self._begin_step(self.model, self.data)
        self.contacts = ContactCounter(self.model, self.data)
        self.step_listeners: list[Callable[[], None]] = []
        """Functions that are called after each advance of the clock."""

    def _advance(self, steps: int) -> None:
        finish, begin, model, data = self._finish_step, self._begin_step, self.model, self.data
        update_contacts = self.contacts.update
        for _ in range(steps):
            finish(model, data)
            begin(model, data)
            update_contacts()
        self.require_sound()
        for listener in self.step_listeners:
            listener()

    def require_sound(self) -> None:
        """Raise BackendError, with MuJoCo's message, if MuJoCo has reset the simulation.

        If a velocity becomes too great, MuJoCo moves all bodies back to the start, and continues with a warning.
        """
        warning = self.data.warning
        if warning.number.any():
            from mujoco import mju_warningText

            kind = int(warning.number.argmax())
            text = mju_warningText(kind, int(warning.lastinfo[kind]))
            raise BackendError(
                f"mujoco: {text} Check the masses and torques in the robot's description", kind="state-lost"
            )


class ContactCounter:
    """Counts the contacts of the robot's body with other bodies, except the floor.

    A contact counts once, even if it lasts for many steps.
    """

    def __init__(self, model: MjModel, data: MjData) -> None:
        from mujoco import mj_geomDistance, mjtGeom

        self.count = 0
        self._model, self._data = model, data
        self._distance = mj_geomDistance
        self._body = int(model.body(BASE).geomadr[0])
        self._ignored = {self._body, *np.flatnonzero(model.geom_type == mjtGeom.mjGEOM_PLANE).tolist()}
        self._touched: set[int] = set()

    def update(self) -> None:
        """Count the contacts that began in the last physics step."""
        pairs = self._data.contact.geom.tolist()
        touching = {thing for pair in pairs if self._body in pair for thing in pair} - self._ignored
        if touching or self._touched:
            self.count += len(touching - self._touched)
            self._touched = touching | {thing for thing in self._touched if self._is_near(thing)}

    def _is_near(self, thing: int) -> bool:
        return bool(self._distance(self._model, self._data, self._body, thing, 2 * RELEASE_M, None) <= RELEASE_M)


Array = NDArray[np.float64]


class Body:
    """The body of the robot in MuJoCo. The origin of its frame is on the floor under the middle of the axle."""

    def __init__(self, model: MjModel, data: MjData, description: RobotDescription) -> None:
        self._data = data
        self.body_id = model.body(BASE).id
        self._is_free = description.drive is not None
        self._joints = _joints(model, description)

    def find_joint(self, device: str) -> int:
        """Return the index, in MuJoCo's array of positions, of the joint of a device's wheel.

        device: the name of a motor or an encoder. Raises DeviceError if the device is on no wheel.
        """
        if device not in self._joints:
            raise DeviceError(
                device, "the device is on no wheel. Name it in the robot's [drive], or leave it out", kind="no-wheel"
            )
        return self._joints[device]

    def angle(self, joint: int) -> float:
        """Return the angle of a wheel in radians.

        joint: the index of the wheel's joint, from `find_joint`.
        """
        return float(self._data.qpos[joint])

    def transform(self) -> tuple[Array, Array]:
        """Return the pose of the robot's frame in the world: a rotation matrix (3, 3), and an origin (3,) in metres."""
        data = self._data
        return data.xmat[self.body_id].reshape(3, 3), data.xpos[self.body_id]

    def pose(self) -> Pose:
        """Return the pose of the middle of the axle on the floor."""
        rotation, origin = self.transform()
        return Pose(float(origin[0]), float(origin[1]), math.atan2(rotation[1, 0], rotation[0, 0]))

    def twist(self) -> Twist:
        """Return the velocity of the middle of the axle."""
        if not self._is_free:
            return Twist(0.0, 0.0)
        velocity = self._data.qvel
        return Twist(float(self.transform()[0][:, 0] @ velocity[:3]), float(velocity[5]))


def _joints(model: MjModel, description: RobotDescription) -> dict[str, int]:
    if (drive := description.drive) is None:
        return {}
    return {name: int(model.joint(wheel_joint(motor)).qposadr[0]) for name, motor in drive.wheel_motors.items()}


class MujocoTruth:
    """The true state of the robot. The methods raise BackendError if MuJoCo has reset the simulation."""

    def __init__(self, body: Body, physics: Physics) -> None:
        self._body, self._physics = body, physics

    def pose(self) -> Pose:
        self._physics.require_sound()
        return self._body.pose()

    def twist(self) -> Twist:
        self._physics.require_sound()
        return self._body.twist()

    def contacts(self) -> int:
        self._physics.require_sound()
        return self._physics.contacts.count

"""What MuJoCo knows of the robot."""

from __future__ import annotations

from drivers.mujoco.body import Body
from drivers.mujoco.physics import Physics
from robotcore.geometry import Pose, Twist


class MujocoTruth:
    """The true state of the robot. Raises BackendError where MuJoCo has lost it."""

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
        return self._physics.touches.count

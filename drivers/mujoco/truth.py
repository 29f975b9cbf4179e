"""What MuJoCo knows of the robot."""

from __future__ import annotations

from drivers.mujoco.body import Body
from drivers.mujoco.physics import Touches
from robotcore.geometry import Pose, Twist


class MujocoTruth:
    """The true state of the robot."""

    def __init__(self, body: Body, touches: Touches) -> None:
        self._body, self._touches = body, touches

    def pose(self) -> Pose:
        return self._body.pose()

    def twist(self) -> Twist:
        return self._body.twist()

    def contacts(self) -> int:
        return self._touches.count

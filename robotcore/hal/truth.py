"""What a simulator knows besides: the word against which a run's own claim is checked."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from robotcore.description import Ball, CameraDescription, RobotDescription, WorldDescription
from robotcore.geometry import Pose, Twist
from robotcore.optics import CameraView
from robotcore.raycast import cast, edges_of

REST_LINEAR_M_S = 0.01
REST_ANGULAR_RAD_S = 0.05

RELEASE_M = 0.001
"""A touch is over when the body has drawn back from the thing by this much."""


class TruthSource(Protocol):
    """What a simulator backend gives: the robot's true pose and velocity, and its touches.

    ``contacts`` counts touches of anything but the floor; one touch is one, however long it lasts. It is None where the
    simulator does not tell.
    """

    def pose(self) -> Pose: ...
    def twist(self) -> Twist: ...
    def contacts(self) -> int | None: ...


class Truth:
    """The true state of a run, seen against its descriptions."""

    def __init__(self, source: TruthSource, robot: RobotDescription, world: WorldDescription) -> None:
        self._source, self._robot, self._world = source, robot, world
        camera, ball = robot.first_of(CameraDescription), world.target
        tall = max(camera.mount.z_m if camera else 0.0, 2 * ball.radius_m if ball else 0.0)
        self._edges = edges_of(prism.outline for prism in world.prisms if prism.height_m >= tall)

    @property
    def pose(self) -> Pose:
        return self._source.pose()

    @property
    def contacts(self) -> int | None:
        return self._source.contacts()

    @property
    def is_at_rest(self) -> bool:
        twist = self._source.twist()
        return abs(twist.linear) < REST_LINEAR_M_S and abs(twist.angular) < REST_ANGULAR_RAD_S

    @property
    def distance_to_target(self) -> float | None:
        """From the front edge of the body to the first target's surface, in plan, in metres."""
        if (ball := self._world.target) is None:
            return None
        body = self._robot.body
        x, y = self.pose.to_local(ball.x_m, ball.y_m)
        beside = max(abs(y) - body.width_m / 2, 0.0)
        return math.hypot(x - body.front_x_m, beside) - ball.radius_m

    @property
    def sees_target(self) -> bool:
        """Whether some of the first target is in the first camera's picture and in line of sight.

        What the camera looks over, or what the ball stands out above, hides nothing.
        """
        camera = self._robot.first_of(CameraDescription)
        ball = self._world.target
        if camera is None or ball is None:
            return False
        view = CameraView.of(camera.intrinsics, camera.mount, self.pose)
        points = _points_across(ball, view)
        eye_x, eye_y = float(view.eye[0]), float(view.eye[1])
        reach = cast(eye_x, eye_y, points[:, 0] - eye_x, points[:, 1] - eye_y, self._edges)
        return bool((view.shows(points) & (reach > 1)).any())


def _points_across(ball: Ball, view: CameraView) -> np.ndarray:
    """Return the ball's centre and two points left and right of it as seen from the eye, (3, 3)."""
    dx, dy = ball.x_m - view.eye[0], ball.y_m - view.eye[1]
    scale = 0.7 * ball.radius_m / math.hypot(dx, dy)
    return np.array([(ball.x_m - s * dy * scale, ball.y_m + s * dx * scale, ball.radius_m) for s in (0, -1, 1)])

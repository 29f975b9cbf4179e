"""The true state of a simulated robot, with which the app's result is compared."""

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
"""A contact ends when the gap between the robot and the other body is larger than this, in metres."""


class TruthSource(Protocol):
    """The interface of a simulator for the true state of its robot."""

    def pose(self) -> Pose:
        """Return the pose of the axle's centre in the world."""

    def twist(self) -> Twist:
        """Return the velocity of the axle's centre."""

    def contacts(self) -> int | None:
        """Return the number of contacts so far with bodies other than the floor. None if it is unknown.

        A long contact counts as one.
        """


class Truth:
    """The true state of a run. An app's `verify` gets it at the end of a run in a simulator."""

    def __init__(self, source: TruthSource, robot: RobotDescription, world: WorldDescription) -> None:
        self._source, self._robot, self._world = source, robot, world
        camera, ball = robot.first_of(CameraDescription), world.target
        tall = max(camera.mount.z_m if camera else 0.0, 2 * ball.radius_m if ball else 0.0)
        self._edges = edges_of(prism.outline for prism in world.prisms if prism.height_m >= tall)

    def __repr__(self) -> str:
        return f"Truth(pose={self.pose}, contacts={self.contacts})"

    @property
    def pose(self) -> Pose:
        """The pose of the axle's centre in the world."""
        return self._source.pose()

    @property
    def contacts(self) -> int | None:
        """The number of contacts so far; None if it is unknown."""
        return self._source.contacts()

    @property
    def is_at_rest(self) -> bool:
        """Whether the robot is slower than 0.01 m/s and 0.05 rad/s."""
        twist = self._source.twist()
        return abs(twist.linear) < REST_LINEAR_M_S and abs(twist.angular) < REST_ANGULAR_RAD_S

    @property
    def distance_to_target(self) -> float | None:
        """The distance from the body's front to the first target's surface, seen from above, in metres.

        None if the world has no target.
        """
        if (ball := self._world.target) is None:
            return None
        body = self._robot.body
        x, y = self.pose.to_local(ball.x_m, ball.y_m)
        beside = max(abs(y) - body.width_m / 2, 0.0)
        return math.hypot(x - body.front_x_m, beside) - ball.radius_m

    @property
    def sees_target(self) -> bool:
        """Whether the first camera sees a part of the first target.

        Obstacles that are lower than the camera or the ball hide nothing.
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
    """Return three points of a ball in the world, one per row, shape (3, 3).

    They are its centre, its rightmost and its leftmost point as seen from the camera.
    """
    dx, dy = ball.x_m - view.eye[0], ball.y_m - view.eye[1]
    scale = 0.7 * ball.radius_m / math.hypot(dx, dy)
    return np.array([(ball.x_m - s * dy * scale, ball.y_m + s * dx * scale, ball.radius_m) for s in (0, -1, 1)])

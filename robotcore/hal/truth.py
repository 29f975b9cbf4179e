"""The true state of a simulated robot, which an app's `verify` and tests check."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from robotcore.description import Ball, Mount, RobotDescription, WorldDescription
from robotcore.geometry import Pose, Twist
from robotcore.hal.line_progress import LineProgress
from robotcore.hal.simulation_state import SimulationState
from robotcore.optics import CameraView
from robotcore.raycast import cast, edges_of

__all__ = ["Truth", "TruthSource"]

REST_LINEAR_M_S = 0.01
REST_ANGULAR_RAD_S = 0.05

RELEASE_M = 0.001
"""The gap, in metres, between the robot and another body at which their contact ends."""


class TruthSource(Protocol):
    """The methods by which a simulator reports the true state of its robot.

    >>> from robotcore import Pose, Truth, Twist
    >>> from robotcore.description import load_robot, load_world
    >>> class Standing:
    ...     def pose(self):
    ...         return Pose(0.5, 0.0, 0.0)
    ...
    ...     def twist(self):
    ...         return Twist(0.0, 0.0)
    ...
    ...     def contacts(self):
    ...         return 0
    >>> Truth(Standing(), load_robot("rover"), load_world("open"))
    Truth(pose=Pose(x=0.5 m, y=0 m, heading=0 rad), contacts=0)
    """

    def pose(self) -> Pose:
        """Return the true pose of the axle's centre in the world, with a heading from -π to π. See `Truth.pose`."""

    def twist(self) -> Twist:
        """Return the true velocity of the axle's centre."""

    def contacts(self) -> int | None:
        """Return the number of contacts since the start with bodies other than the floor; None if it is unknown.

        A long contact counts as one.
        """


class Truth:
    """The true state of a simulated robot. An app's `verify` gets it at the end of a run.

    source: the simulator's methods.
    robot: the description of the robot.
    world: the description of the world.

    >>> import robotcore
    >>> with robotcore.open("rover", world="arena") as robot:
    ...     twist = robot.drive.straight(0.2)  # metres
    ...     robot.ground_truth.contacts, robot.ground_truth.is_at_rest
    ...     robot.ground_truth.distance_to_target > 0.2
    (0, True)
    True
    """

    def __init__(self, source: TruthSource, robot: RobotDescription, world: WorldDescription) -> None:
        self._source, self._world = source, world
        state = self.state
        self._robot = robot = state.robot if state else robot  # the simulated robot may differ from the robot's file
        camera, ball = robot.first_of("camera"), world.target
        tall = max(camera.mount.z_m if camera else 0.0, 2 * ball.radius_m if ball else 0.0)
        self.line = LineProgress(world.lines[0]) if world.lines else None
        """How the robot has followed the first line of the world since the start; None in a world without lines."""
        self._edges = edges_of(prism.outline for prism in world.prisms if prism.height_m >= tall)

    @property
    def state(self) -> SimulationState | None:
        """The state from which the devices are simulated; None if another program simulates them."""
        return getattr(self._source, "simulation_state", None)

    def update(self) -> None:
        """Measure the robot's way along the line. A run calls this once in each tick."""
        if self.line:
            self.line.update(self.pose)

    def __repr__(self) -> str:
        return f"Truth(pose={self.pose}, contacts={self.contacts})"

    @property
    def pose(self) -> Pose:
        """The true pose of the axle's centre in the world. Its heading is from -π to π, in every simulator.

        A simulator has the robot's orientation, but does not count its turns. A heading that counts turns would
        depend on how often it is read. Odometry adds up the turns of the wheels, so the heading of `robot.drive.pose`
        counts them.
        """
        return self._source.pose()

    @property
    def contacts(self) -> int | None:
        """The number of the robot's contacts with other bodies since the start; None if it is unknown."""
        return self._source.contacts()

    @property
    def is_at_rest(self) -> bool:
        """Whether the robot is slower than 0.01 m/s and 0.05 rad/s."""
        twist = self._source.twist()
        return abs(twist.linear) < REST_LINEAR_M_S and abs(twist.angular) < REST_ANGULAR_RAD_S

    @property
    def distance_to_target(self) -> float | None:
        """The horizontal distance from the robot's front to the first target's surface, in metres.

        It is None if the world has no target.
        """
        if (ball := self._world.target) is None:
            return None
        body = self._robot.body
        x, y = self.pose.to_local(ball.x_m, ball.y_m)
        beside = max(abs(y) - body.width_m / 2, 0.0)
        return math.hypot(x - body.front_x_m, beside) - ball.radius_m

    @property
    def sees_target(self) -> bool:
        """Whether a part of the first target is visible to the first camera.

        Obstacles that are lower than the camera or the ball are ignored.
        """
        camera = self._robot.first_of("camera")
        ball = self._world.target
        if camera is None or ball is None:
            return False
        view = CameraView.of(camera.intrinsics, self._locate(camera.mount), self.pose)
        points = _points_across(ball, view)
        eye_x, eye_y = float(view.eye[0]), float(view.eye[1])
        reach = cast(eye_x, eye_y, points[:, 0] - eye_x, points[:, 1] - eye_y, self._edges)
        return bool((view.shows(points) & (reach > 1)).any())

    def _locate(self, mount: Mount) -> Mount:
        return self.state.joints.locate(mount) if self.state else mount  # only simulators in this process have servos


def _points_across(ball: Ball, view: CameraView) -> np.ndarray:
    """Return the ball's centre, and a point to the right and to the left of it as seen by the camera, shape (3, 3)."""
    dx, dy = ball.x_m - view.eye[0], ball.y_m - view.eye[1]
    scale = 0.7 * ball.radius_m / math.hypot(dx, dy)
    return np.array([(ball.x_m - s * dy * scale, ball.y_m + s * dx * scale, ball.radius_m) for s in (0, -1, 1)])

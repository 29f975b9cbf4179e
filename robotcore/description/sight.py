"""What can be seen of a target from somewhere in a world, whichever way one looks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robotcore.description.robot import CameraDescription, RobotDescription
from robotcore.description.world import Ball, WorldDescription
from robotcore.optics import View
from robotcore.raycast import cast, edges_of

Array = NDArray[np.float64]

PARTS = np.linspace(-1.0, 1.0, 7)
"""Where across a ball it is looked for, in radii."""

HEADINGS = 12
"""How many ways a robot turns when it looks around."""


def visible_parts(eyes: Array, ball: Ball, edges: Array) -> NDArray[np.bool_]:
    """Return which parts across the ball are in line of sight from each eye, (n, 2): (n, 7)."""
    to_ball = np.array((ball.x_m, ball.y_m)) - eyes
    distance = np.maximum(np.hypot(to_ball[:, 0], to_ball[:, 1]), ball.radius_m)[:, None]
    left = np.stack((-to_ball[:, 1], to_ball[:, 0]), axis=1) / distance
    rays = to_ball[:, None] + left[:, None] * (PARTS * ball.radius_m)[:, None]
    dx, dy = rays.reshape(-1, 2).T
    from_x, from_y = np.repeat(eyes, len(PARTS), axis=0).T
    return np.asarray(cast(from_x, from_y, dx, dy, edges) > 1).reshape(-1, len(PARTS))


def is_target_hidden(world: WorldDescription, robot: RobotDescription) -> bool:
    """Return whether nothing of the first target is in line of sight at the start, however the robot turns.

    What the camera looks over, or what the ball stands out above, hides nothing.
    """
    if (ball := world.target) is None:
        return False
    camera = robot.first_of(CameraDescription)
    eye_height = camera.mount.z_m if camera else robot.body.height_m
    tall = max(eye_height, 2 * ball.radius_m)
    edges = edges_of(prism.outline for prism in world.prisms if prism.height_m >= tall)
    return not visible_parts(_eyes_around_start(world, camera), ball, edges).any()


def is_target_in_view(world: WorldDescription, robot: RobotDescription) -> bool:
    """Return whether all of the first target is in the first camera's picture at the start."""
    camera, ball = robot.first_of(CameraDescription), world.target
    if camera is None or ball is None:
        return False
    view = View.of(camera.intrinsics, camera.mount, world.start.pose)
    edges = edges_of(prism.outline for prism in world.prisms)
    reach = ball.radius_m * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
    corners = np.array([(ball.x_m + x, ball.y_m + y, z) for x, y in reach for z in (0.0, 2 * ball.radius_m)])
    return bool(view.shows(corners).all() and visible_parts(view.eye[None, :2], ball, edges).all())


def _eyes_around_start(world: WorldDescription, camera: CameraDescription | None) -> Array:
    """Return where the camera comes to while the robot turns on the spot, and the start itself, (n, 2)."""
    start = world.start
    eyes = [(start.x_m, start.y_m)]
    if camera:
        reach = math.hypot(camera.mount.x_m, camera.mount.y_m)
        angles = [turn * math.tau / HEADINGS for turn in range(HEADINGS)]
        eyes += [(start.x_m + reach * math.cos(a), start.y_m + reach * math.sin(a)) for a in angles]
    return np.array(eyes)

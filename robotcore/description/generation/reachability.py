"""Checks whether a robot can reach the target of a world, and whether the target is visible from the start."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.description.robot import RobotDescription
from robotcore.description.world import Ball, WorldDescription
from robotcore.optics import CameraView
from robotcore.raycast import cast, edges_of

Array = NDArray[np.float64]

CELL_M = 0.025
MAX_CELLS = 2000
"""The greatest number of cells along a side of a `FreeSpace`. In a world larger than 50 m, cells exceed `CELL_M`."""

OPEN_MARGIN_M = 1.0
"""The width, in metres, of the strip around all bodies in the `FreeSpace` of a world without walls."""

ARRIVAL_GAP_M = 0.28
"""The distance, in metres, from the robot's front to the ball at which the robot arrives."""

ARRIVALS = 72
"""The number of directions from which arrivals at the ball are checked."""


def is_solvable(world: WorldDescription, robot: RobotDescription) -> bool:
    """Return whether the robot can drive to the first target.

    The robot must have room to turn on the spot along the whole path. All of the target must be visible where the robot
    arrives. Return True if the world has no target or the robot has no drive.
    """
    if (ball := world.target) is None or robot.drive is None:
        return True
    points = _arrival_points(ball, robot)
    edges = edges_of(prism.outline for prism in world.prisms)
    is_visible = visible_parts(points, ball, edges).all(axis=1)
    return bool((FreeSpace(world).is_reachable(points, robot.body.reach_m) & is_visible).any())


class FreeSpace:
    """A grid with the distance from each cell to the nearest body.

    The row of a cell grows with y, and the column grows with x. ``cell_m`` is the length of a cell's sides in metres.
    """

    def __init__(self, world: WorldDescription) -> None:
        self._start = np.array([(world.start.x_m, world.start.y_m)])
        half = _half_extent(world)
        self.cell_m = max(CELL_M, 2 * half.max() / MAX_CELLS)
        columns, rows = (np.ceil(2 * half / self.cell_m).astype(int) + 2).tolist()
        self._origin = -(np.array((columns, rows)) - 1) / 2 * self.cell_m
        self._clearance = cv2.distanceTransform(self._paint(world, rows, columns), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        self._clearance *= self.cell_m

    def is_reachable(self, points: Array, radius: float) -> NDArray[np.bool_]:
        """Return for each point whether a disc can move there from the start, shape (n,).

        points: the points, in metres, shape (n, 2).
        radius: the radius of the disc in metres.
        """
        is_clear = (self._clearance >= radius).astype(np.uint8)
        _, labels = cv2.connectedComponents(is_clear, connectivity=4)
        columns, rows = self._cells(np.concatenate((self._start, points)))
        start, *ends = labels[rows, columns]
        return np.asarray((np.array(ends) == start) & (start > 0))

    def _cells(self, points: Array) -> NDArray[np.int64]:
        # Points outside the grid are in cells of the border.
        cells = np.rint((points - self._origin) / self.cell_m).astype(np.int64)
        rows, columns = self._clearance.shape
        return np.asarray(np.clip(cells, 0, (columns - 1, rows - 1)).T)

    def _paint(self, world: WorldDescription, rows: int, columns: int) -> NDArray[np.uint8]:
        # 0 in the cells of bodies and of the border, and 1 elsewhere.
        image = np.zeros((rows, columns), np.uint8)
        image[1:-1, 1:-1] = 1
        for body in world.bodies:
            corners = (np.array(body.outline) - self._origin) / self.cell_m
            cv2.fillConvexPoly(image, np.rint(corners * 16).astype(np.int32), 0, shift=4)
        return image


def _half_extent(world: WorldDescription) -> Array:
    half = np.array((world.floor.length_m, world.floor.width_m)) / 2
    if world.walls:
        return half
    corners = [corner for body in world.bodies for corner in body.outline]
    corners.append((world.start.x_m, world.start.y_m))
    return np.asarray(np.maximum(half, np.abs(np.array(corners)).max(axis=0)) + OPEN_MARGIN_M)


def _arrival_points(ball: Ball, robot: RobotDescription) -> Array:
    """Return the positions of the axle at which the robot may arrive at the ball, shape (ARRIVALS, 2)."""
    distance = ball.radius_m + ARRIVAL_GAP_M + robot.body.front_x_m
    angles = np.arange(ARRIVALS) * (math.tau / ARRIVALS)
    return np.stack((ball.x_m + distance * np.cos(angles), ball.y_m + distance * np.sin(angles)), axis=1)


POINTS_ACROSS = np.linspace(-1.0, 1.0, 7)
"""The points of a ball whose visibility is checked, from right to left, in multiples of the ball's radius."""

HEADINGS = 12
"""The number of headings of the robot at the start for which visibility is checked."""


def visible_parts(eyes: Array, ball: Ball, edges: Array) -> NDArray[np.bool_]:
    """Return whether the line of sight is free from camera positions to the `POINTS_ACROSS` of a ball, shape (n, 7).

    eyes: the positions of the camera, in metres, shape (n, 2).
    ball: the ball.
    edges: the edges that block the view, as `robotcore.raycast.edges_of` returns them.
    """
    to_ball = np.array((ball.x_m, ball.y_m)) - eyes
    distance = np.maximum(np.hypot(to_ball[:, 0], to_ball[:, 1]), ball.radius_m)[:, None]
    left = np.stack((-to_ball[:, 1], to_ball[:, 0]), axis=1) / distance
    rays = to_ball[:, None] + left[:, None] * (POINTS_ACROSS * ball.radius_m)[:, None]
    dx, dy = rays.reshape(-1, 2).T
    from_x, from_y = np.repeat(eyes, len(POINTS_ACROSS), axis=0).T
    return np.asarray(cast(from_x, from_y, dx, dy, edges) > 1).reshape(-1, len(POINTS_ACROSS))


def is_target_hidden(world: WorldDescription, robot: RobotDescription) -> bool:
    """Return whether obstacles hide all of the first target from a robot that turns on the spot at the start.

    Obstacles that are lower than the camera or the target are ignored.
    """
    if (ball := world.target) is None:
        return False
    camera = robot.first_of("camera")
    eye_height = camera.mount.z_m if camera else robot.body.height_m
    tall = max(eye_height, 2 * ball.radius_m)
    edges = edges_of(prism.outline for prism in world.prisms if prism.height_m >= tall)
    return not visible_parts(_eyes_around_start(world, camera), ball, edges).any()


def is_target_in_view(world: WorldDescription, robot: RobotDescription) -> bool:
    """Return whether all of the first target is in view of the first camera at the start."""
    camera, ball = robot.first_of("camera"), world.target
    if camera is None or ball is None:
        return False
    view = CameraView.of(camera.intrinsics, camera.mount, world.start.pose)
    edges = edges_of(prism.outline for prism in world.prisms)
    reach = ball.radius_m * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
    corners = np.array([(ball.x_m + x, ball.y_m + y, z) for x, y in reach for z in (0.0, 2 * ball.radius_m)])
    return bool(view.shows(corners).all() and visible_parts(view.eye[None, :2], ball, edges).all())


def _eyes_around_start(world: WorldDescription, camera: Any) -> Array:
    """Return the start, and the positions of the camera while the robot turns on the spot there, shape (n, 2)."""
    start = world.start
    eyes = [(start.x_m, start.y_m)]
    if camera:
        reach = math.hypot(camera.mount.x_m, camera.mount.y_m)
        angles = [turn * math.tau / HEADINGS for turn in range(HEADINGS)]
        eyes += [(start.x_m + reach * math.cos(a), start.y_m + reach * math.sin(a)) for a in angles]
    return np.array(eyes)

"""A robot that learns its surroundings and finds its way through them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose, Twist
from robotcore.navigation.grid import OccupancyGrid
from robotcore.navigation.paths import UNREACHED, Cell, is_straight_way, path_back, steps_from, view_gains
from robotcore.robot import Robot

MARGINS_M = (0.08, 0.05, 0.025, 0.0)
"""How much more than its own reach the robot keeps from things; the next where the one before leaves no way."""

CARROT_M = 0.5
ARRIVED_M = 0.05
TURN_FIRST_RAD = 0.4
MIN_GAIN_CELLS = 60.0
VIEW_M = 2.0
KNOWN_M = 0.45
CORRIDOR_M = 0.24

Mask = NDArray[np.bool_]


class Navigator:
    """Keeps a map in the odometry's frame, plans in what is known to be free, and follows the plan.

    ``speed`` in m/s, ``turn`` in rad/s.
    """

    def __init__(self, speed: float, turn: float) -> None:
        self.grid = OccupancyGrid()
        self._speed, self._turn = speed, turn
        self._reach = 0.0
        self._path: list[Cell] = []
        self._open: Mask = np.zeros((1, 1), dtype=np.bool_)
        self._heard = -1

    def observe(self, robot: Robot, pose: Pose) -> None:
        """Take in what the robot's range sensor says at ``pose``; a reading that is known already is left out."""
        sensor, self._reach = robot.range, robot.drive.reach
        sample = sensor.read()
        if sample.sequence != self._heard:
            self._heard = sample.sequence
            self.grid.add_range(pose.moved(sensor.mount), sample.distance, sensor.max_range, sensor.cone)
            self.grid.add_free_disc(pose.x, pose.y, self._reach)

    def forget(self) -> None:
        """Begin a new map: what was learnt leads nowhere."""
        self.grid = OccupancyGrid()
        self._path = []

    def plan_to_view(self, pose: Pose) -> bool:
        """Plan to where most that is unknown can be seen for the way; return False where nothing is left to see."""
        taken = self.grid.taken
        unknown = ~taken & ~self.grid.free
        for margin in MARGINS_M:
            steps = self._steps(pose, margin)
            cells = np.argwhere(steps != UNREACHED)
            cells = cells[((cells % 4) == 0).all(axis=1)]
            if not len(cells):
                continue
            gains = view_gains(cells, taken, unknown, round(VIEW_M / self.grid.cell))
            ways = steps[cells[:, 0], cells[:, 1]] * self.grid.cell
            worth = np.where(gains >= MIN_GAIN_CELLS, gains / (1.0 + ways), 0.0)
            best = int(worth.argmax())
            if worth[best] > 0:
                self._path = path_back(steps, (int(cells[best][0]), int(cells[best][1])))
                return True
        return False

    def plan_to_ring(self, pose: Pose, x: float, y: float, nearest: float, farthest: float) -> bool:
        """Plan to the nearest place whose distance to a point is within the ring and that looks upon the point."""
        centre = self.grid.cell_of(x, y)
        radius = round(farthest / self.grid.cell)
        for margin in MARGINS_M:
            steps = self._steps(pose, margin)
            top, left = max(centre[0] - radius, 0), max(centre[1] - radius, 0)
            around = np.argwhere(
                steps[top : centre[0] + radius + 1, left : centre[1] + radius + 1] != UNREACHED
            ) + (top, left)
            if self._choose(steps, around, centre, nearest):
                return True
        return False

    def follow(self, pose: Pose) -> Twist | None:
        """Return how to move along the plan; None where it is done, or no longer free."""
        if not self._path:
            return None
        if not all(self.grid.evidence[cell] <= 0 for cell in self._path):
            self._path = []
            return None
        here = self.grid.cell_of(pose.x, pose.y)
        x, y = self.grid.point_of(*self._carrot(here))
        away = pose.distance_to(x, y)
        if len(self._path) == 1 and away < ARRIVED_M:
            self._path = []
            return None
        return self.towards(pose.bearing_to(x, y), self._speed * min(1.0, 0.3 + away / 0.3))

    def towards(self, bearing: float, speed: float) -> Twist:
        """Return how to move towards a bearing: turning first where it is far aside."""
        if abs(bearing) > TURN_FIRST_RAD:
            return Twist(0.0, self.turn_to(bearing))
        return Twist(speed * math.cos(bearing), self.turn_to(bearing))

    def turn_to(self, bearing: float) -> float:
        """Return how fast to turn towards a bearing, in rad/s."""
        return max(-self._turn, min(self._turn, 2.5 * bearing))

    def is_straight(self, pose: Pose, distance: float, bearing: float) -> bool:
        """Return whether the way ahead is free: known to be so where it begins, not known to be taken further on."""
        here = self.grid.cell_of(pose.x, pose.y)
        heading = pose.heading + bearing
        middle, there = (
            self.grid.cell_of(pose.x + away * math.cos(heading), pose.y + away * math.sin(heading))
            for away in (min(distance, KNOWN_M), max(distance, 0.0))
        )
        half_width = CORRIDOR_M / 2
        known = self.grid.clearance(with_unknown=True) > half_width
        maybe = self.grid.clearance(with_unknown=False) > half_width
        return is_straight_way(known, here, middle) and is_straight_way(maybe, middle, there)

    def _steps(self, pose: Pose, margin: float) -> NDArray[np.int32]:
        self._open = self.grid.clearance() > self._reach + margin
        here = self.grid.cell_of(pose.x, pose.y)
        row, column = here
        self._open[row - 2 : row + 3, column - 2 : column + 3] = True
        return steps_from(here, self._open)

    def _choose(self, steps: NDArray[np.int32], cells: NDArray[np.intp], centre: Cell, nearest: float) -> bool:
        """Take the cell with the shortest way that is far enough from ``centre`` and looks upon it."""
        looks_upon = ~self.grid.taken
        rows, columns = np.ogrid[: looks_upon.shape[0], : looks_upon.shape[1]]
        beside = np.hypot(rows - centre[0], columns - centre[1]) * self.grid.cell
        looks_upon |= beside < nearest - 0.1
        for row, column in sorted(map(tuple, cells), key=lambda cell: int(steps[cell])):
            if beside[row, column] >= nearest and is_straight_way(looks_upon, (row, column), centre):
                self._path = path_back(steps, (row, column))
                return True
        return False

    def _carrot(self, here: Cell) -> Cell:
        """Return the farthest cell of the path, within CARROT_M, to which the way is straight; forget those before."""
        limit = round(CARROT_M / self.grid.cell)
        best = 0
        for index, cell in enumerate(self._path[: 2 * limit]):
            if math.dist(here, cell) <= limit and is_straight_way(self._open, here, cell):
                best = index
        self._path = self._path[best:]
        return self._path[0]

"""A robot that learns its surroundings and finds its way through them."""

from __future__ import annotations

import math
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose, Twist
from robotcore.navigation.grid import Mask, OccupancyGrid
from robotcore.navigation.paths import UNREACHED, Cell, Steps, is_straight_way, path_back, steps_from
from robotcore.robot import Robot

MARGINS_M = (0.08, 0.05, 0.02)
"""How much more than its own reach the robot keeps from things; the next where the one before leaves no way."""

NEWS = 0.01
"""Metres or radians by which a reading must differ from the last one."""

CARROT_M = 0.5
ARRIVED_M = 0.05
TURN_FIRST_RAD = 0.4
KNOWN_M = 0.45
CORRIDOR_M = 0.24
MIN_GAIN_M2 = 0.1
TURN_GAIN_M2 = 0.05
ELSEWHERE_M = 0.3
LOOK_ROUND_M = 1.2
"""The way that could be driven in the time that looking round takes."""
GAIN_ANGLES = np.linspace(0.0, math.tau, 36, endpoint=False, dtype=np.float64)
GAIN_STEP = 2


class Navigator:
    """Keeps a map in the odometry's frame, plans in what is known to be free, and follows the plan.

    ``speed`` in m/s, ``turn`` in rad/s. A ``target`` is a ball that stands out of the map: its place and radius.
    """

    def __init__(self, speed: float, turn: float) -> None:
        self.grid = OccupancyGrid()
        self._speed, self._turn = speed, turn
        self._reach = 0.0
        self._path: list[Cell] = []
        self._open: Mask = np.zeros((1, 1), dtype=np.bool_)
        self._heard: tuple[float, ...] | None = None
        self._barred: Mask = np.zeros_like(self.grid.taken)
        self._ahead: list[Cell] = []
        self._gain_of = None
        self._least = 0.0

    def observe(self, robot: Robot, pose: Pose) -> None:
        """Take in what the robot hears and where it looks at ``pose``.

        A reading that repeats the last one, from the same place, is no new evidence.
        """
        sensor, self._reach = robot.range, robot.drive.reach
        reading = (*pose, sensor.read().distance)
        if self._heard is None or any(abs(a - b) > NEWS for a, b in zip(reading, self._heard, strict=True)):
            self._heard = reading
            self.grid.add_range(pose.moved(sensor.mount), reading[3], sensor.max_range, sensor.cone)
            self.grid.add_free_disc(pose.x, pose.y, self._reach, robot.drive.geometry.track / 2)
            self.grid.add_view(pose.moved(robot.camera.mount), robot.camera.intrinsics.horizontal_fov)

    def forget(self) -> None:
        """Begin a new map: what was learnt leads nowhere."""
        self.grid = OccupancyGrid()
        self._path = []
        self._barred[:] = False

    def plan_to_view(self, pose: Pose) -> bool:
        """Plan to where most can be seen that was not looked at, for the way; return False where there is nothing.

        Call it when the robot has looked all round at ``pose``.
        """
        self.grid.add_look_round(pose.x, pose.y)
        for gains_of, least in ((self._gains, MIN_GAIN_M2),):
            most = 0.0
            for level, margin in enumerate(MARGINS_M):
                steps = self._steps(pose, margin)
                cells = np.argwhere(steps != UNREACHED)
                ways = steps[cells[:, 0], cells[:, 1]] * self.grid.cell
                is_candidate = ((cells % 4) == 0).all(axis=1) & (ways >= ELSEWHERE_M)
                cells, ways = cells[is_candidate], ways[is_candidate]
                if not len(cells):
                    continue
                gains = gains_of(cells)
                worth = np.where(gains >= least, gains / (LOOK_ROUND_M + ways), 0.0) * 0.85**level
                best = int(worth.argmax())
                if worth[best] > most:
                    most = float(worth[best])
                    self._gain_of, self._least = gains_of, max(least, 0.3 * float(gains[best]))
                    self.why = (gains_of.__name__, round(float(gains[best]), 2), margin)
                    self._path = path_back(steps, (int(cells[best][0]), int(cells[best][1])))
            if most:
                return True
        return False

    def unseen_bearings(self, pose: Pose) -> NDArray[np.float64]:
        """Return where to turn, to look at what can be seen from here and was not yet."""
        bins = self.grid.unseen(np.array([self.grid.cell_of(pose.x, pose.y)]), GAIN_ANGLES, GAIN_STEP)[0]
        around = bins + np.roll(bins, 1) + np.roll(bins, -1)
        return (GAIN_ANGLES[around >= TURN_GAIN_M2] - pose.heading + math.pi) % math.tau - math.pi

    def is_worth_going(self) -> bool:
        """Return whether what the plan's end was to show is still to be seen."""
        if not self._path:
            return False
        cells = np.array([self._path[-1]])
        return self._gain_of is None or float(self._gain_of(cells)[0]) >= self._least

    def plan_to_ring(
        self, pose: Pose, x: float, y: float, nearest: float, farthest: float, *, is_surveyed: bool
    ) -> bool:
        """Plan to the nearest place whose distance to a point is in the ring, with a straight way on towards it.

        Where no known way leads there, plan as far as is known of one that may be free. A way that, seen from
        its beginning, does not come to be known is barred.
        """
        self._gain_of = None
        for attempt in range(8):
            plan = self._plan_ring(pose, x, y, nearest, farthest)
            if plan is None:
                return False
            path, margin = plan
            known = self._known_part(path, margin)
            self._ahead = path[len(known) :]
            if len(known) * self.grid.cell > ELSEWHERE_M or len(known) == len(path):
                self._path = known
                return len(known) > 1
            if not is_surveyed:
                self._path = []
                return False
            self._bar(path[len(known)])
        return False

    def _plan_ring(self, pose, x, y, nearest, farthest):
        goals = self._ring(x, y, nearest, farthest) & ~self.grid.disc(pose.x, pose.y, 0.15)
        best, plan = math.inf, None
        for kind, (with_unknown, with_doubtful) in enumerate(((True, False), (False, False), (False, True))):
            for level, margin in enumerate(MARGINS_M):
                steps = self._steps(pose, margin, with_unknown=with_unknown, with_doubtful=with_doubtful)
                reached = np.where(goals, steps, UNREACHED)
                goal = np.unravel_index(int(reached.argmin()), reached.shape)
                if reached[goal] == UNREACHED:
                    continue
                cost = reached[goal] * self.grid.cell + (0.0, 0.4, 1.2)[kind] + 0.3 * level
                if cost < best:
                    best, plan = cost, (path_back(steps, (int(goal[0]), int(goal[1]))), margin)
                    self.why = (with_unknown, with_doubtful, margin)
                break
        return plan

    def _ring(self, x, y, nearest, farthest) -> Mask:
        """Return from which cells of the ring the way to the point is straight."""
        centre = self.grid.cell_of(x, y)
        way_on = self._corridor(x, y, nearest, 0.03)
        ring = self.grid.disc(x, y, farthest) & ~self.grid.disc(x, y, nearest)
        goals = np.zeros_like(ring)
        for cell in np.argwhere(ring):
            goals[tuple(cell)] = is_straight_way(way_on, (int(cell[0]), int(cell[1])), centre)
        return goals

    def bearing_ahead(self, pose: Pose) -> float:
        """Return where the way goes on that is not known yet."""
        if not self._ahead:
            return 0.0
        cell = self._ahead[min(len(self._ahead) - 1, 8)]
        return pose.bearing_to(*self.grid.point_of(*cell))

    def _bar(self, cell: Cell) -> None:
        x, y = self.grid.point_of(*cell)
        self._barred |= self.grid.disc(x, y, 0.2)

    def is_straight(self, pose: Pose, x: float, y: float, nearest: float, *, is_surveyed: bool) -> bool:
        """Return whether the way to ``nearest`` metres before a point is free.

        Unless the robot has just looked all round, it must be known to be free where it begins: there the range
        sensor's cone is narrower than the robot.
        """
        here, there = self.grid.cell_of(pose.x, pose.y), self.grid.cell_of(x, y)
        away = max(pose.distance_to(x, y), 1e-6)
        part = max(0.0, min(KNOWN_M, away - nearest)) / away
        middle = self.grid.cell_of(pose.x + part * (x - pose.x), pose.y + part * (y - pose.y))
        known = self.grid.clearance(overlook=self.grid.disc(x, y, nearest - 0.1)) > CORRIDOR_M / 2
        is_known = is_surveyed or is_straight_way(known, here, middle)
        return is_known and is_straight_way(self._corridor(x, y, nearest), here, there)

    def is_free_behind(self, pose: Pose) -> bool:
        """Return whether the robot can back off a little."""
        x, y = pose.to_world(-0.1, 0.0)
        return bool(self.grid.clearance()[self.grid.cell_of(x, y)] > 0.12)

    def follow(self, pose: Pose) -> Twist | None:
        """Return how to move along the plan, made anew where something has come up; None where it is at its end."""
        if self._path and any(self.grid.evidence[cell] > 0 for cell in self._path):
            self._path = self._way_to(pose, self._path[-1])
        while self._path:
            x, y = self.grid.point_of(*self._carrot(self.grid.cell_of(pose.x, pose.y)))
            away = pose.distance_to(x, y)
            if away >= ARRIVED_M:
                return self.towards(pose.bearing_to(x, y), self._speed * min(1.0, 0.3 + away / 0.3))
            self._path.pop(0)
        return None

    def towards(self, bearing: float, speed: float) -> Twist:
        """Return how to move towards a bearing: turning first where it is far aside."""
        if abs(bearing) > TURN_FIRST_RAD:
            return Twist(0.0, self.turn_to(bearing))
        return Twist(speed * math.cos(bearing), self.turn_to(bearing))

    def turn_to(self, bearing: float) -> float:
        """Return how fast to turn towards a bearing, in rad/s."""
        return max(-self._turn, min(self._turn, 2.5 * bearing))

    def _gains(self, cells: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return for each of the cells, (n, 2), how much can be seen from it that was not looked at, in m²."""
        return np.asarray(self.grid.unseen(cells, GAIN_ANGLES, GAIN_STEP).sum(axis=1))

    def _doubts(self, cells: NDArray[np.intp]) -> NDArray[np.float64]:
        return np.asarray(self.grid.doubtful(cells, GAIN_ANGLES, 1).sum(axis=1))

    def _steps(
        self, pose: Pose, margin: float, *, with_unknown: bool = True, with_doubtful: bool = False
    ) -> Steps:
        overlook = self.grid.taken & (self.grid.heard_from > 0.6) if with_doubtful else None
        self._open = self.grid.clearance(with_unknown=with_unknown, overlook=overlook) > self._reach + margin
        if not with_unknown:
            self._open &= ~self._barred
        here = self.grid.cell_of(pose.x, pose.y)
        row, column = here
        beside = slice(row - 2, row + 3), slice(column - 2, column + 3)
        self._open[beside] |= ~self.grid.taken[beside]
        return steps_from(here, self._open)

    def _ring_cell(self, steps: Steps, x: float, y: float, nearest: float, farthest: float) -> Cell | None:
        """Return the cell in the ring with the shortest way to it, and a straight one on from it."""
        centre = self.grid.cell_of(x, y)
        way_on = self._corridor(x, y, nearest)
        ring = (steps != UNREACHED) & self.grid.disc(x, y, farthest) & ~self.grid.disc(x, y, nearest)
        cells = np.argwhere(ring)
        for index in np.argsort(steps[ring], kind="stable"):
            cell = int(cells[index][0]), int(cells[index][1])
            if is_straight_way(way_on, cell, centre):
                return cell
        return None

    def _way_to(self, pose: Pose, goal: Cell) -> list[Cell]:
        """Return a way to a cell, with the widest margin that there is; empty where there is none."""
        for margin in MARGINS_M:
            steps = self._steps(pose, margin)
            if steps[goal] != UNREACHED:
                return path_back(steps, goal)
        return []

    def _known_part(self, path: list[Cell], margin: float) -> list[Cell]:
        """Return a path up to where it leaves what is known to be free; where the robot stands counts as free."""
        is_known = self.grid.clearance() > self._reach + margin
        return path[:2] + list(takewhile(lambda cell: is_known[cell], path[2:]))

    def _corridor(self, x: float, y: float, nearest: float, spare: float = 0.0) -> Mask:
        """Return where nothing is known to be in the way to a point; what is round the point is the target itself."""
        target = self.grid.disc(x, y, nearest - 0.1)
        return (self.grid.clearance(with_unknown=False, overlook=target) > CORRIDOR_M / 2 + spare) | target

    def _carrot(self, here: Cell) -> Cell:
        """Return the farthest cell of the path, within CARROT_M, to which the way is straight; forget those before."""
        limit = round(CARROT_M / self.grid.cell)
        best = 0
        for index, cell in enumerate(self._path[: 2 * limit]):
            if math.dist(here, cell) <= limit and is_straight_way(self._open, here, cell):
                best = index
        self._path = self._path[best:]
        return self._path[0]

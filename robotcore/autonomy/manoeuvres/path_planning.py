"""Plans paths of straight lines and arcs through points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

from robotcore.autonomy.manoeuvres.path import Path, Piece
from robotcore.errors import UsageError
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.drive import DifferentialDrive

Point: TypeAlias = tuple[float, float]
"""The x and y of a point in metres."""

SAME_M = 0.003
"""Points that are nearer to each other than this are the same, in metres. Robots do not stand more exactly."""

CUT_M = 0.01
"""How far the path of a robot that can turn on the spot may pass from a corner that it rounds, in metres."""

MIN_CORNER_RAD = 1e-6
"""Half of the least angle of a corner, in radians. Below it, rounding errors are too large."""

RADIUS_FACTOR = 1.1
"""The radius of the arcs of a robot that steers, divided by its smallest one. The rest is for corrections."""


class _Corner(NamedTuple):
    """A rounded corner between two lines."""

    angle: float
    """The angle by which the direction changes, in radians, positive to the left."""
    radius: float
    """The radius of the arc, in metres; 0 for a turn on the spot."""

    @property
    def tangent(self) -> float:
        """The distance from the corner to each end of the arc, in metres."""
        return self.radius * math.tan(abs(self.angle) / 2) if self.radius else 0.0


def split_at_turns(start: Point, points: Sequence[Point], drive: DifferentialDrive) -> list[list[Point]]:
    """Return the points in groups. Between two groups, the robot turns on the spot; it drives through a group.

    start: the place of the robot.

    Raises UsageError if the robot steers, and a corner is too sharp for it.
    """
    places = list(_drop_repetitions(start, points))
    groups: list[list[Point]] = [places[1:2]] if places[1:] else []
    for index in range(1, len(places) - 1):
        if not drive.min_turn_radius and not _round_corner(places, index, drive).radius:
            groups.append([])
        groups[-1].append(places[index + 1])
    return groups


def plan_path(start: Pose, points: Sequence[Point], drive: DifferentialDrive) -> Path:
    """Return a path through points, whose corners are rounded.

    start: the pose of the robot. A robot that can turn on the spot has turned to the first point.

    Raises UsageError if the robot steers, and a point is inside of its sharpest turn.
    """
    pieces: list[Piece] = []
    first = points[0]
    if drive.min_turn_radius:
        bend = _bend_to(start, first, RADIUS_FACTOR * drive.min_turn_radius)
        pieces, start = [bend], bend.end
    heading = math.atan2(first[1] - start.y, first[0] - start.x)
    places = [(start.x, start.y), *points]
    at = Pose(start.x, start.y, heading)
    for index in range(1, len(places) - 1):
        corner = _round_corner(places, index, drive)
        pieces.append(Piece(at, at.distance_to(*places[index]) - corner.tangent))
        arc = Piece(pieces[-1].end, corner.radius * abs(corner.angle), math.copysign(1 / corner.radius, corner.angle))
        pieces.append(arc)
        at = arc.end
    pieces.append(Piece(at, at.distance_to(*places[-1])))
    return Path([piece for piece in pieces if piece.length > 0])


def _round_corner(places: Sequence[Point], index: int, drive: DifferentialDrive) -> _Corner:
    before, corner, after = places[index - 1 : index + 2]
    into, out = math.dist(before, corner), math.dist(corner, after)
    direction = math.atan2(corner[1] - before[1], corner[0] - before[0])
    angle = wrap_angle(math.atan2(after[1] - corner[1], after[0] - corner[0]) - direction)
    half = max(abs(angle) / 2, MIN_CORNER_RAD)
    room = (into if index == 1 else into / 2, out if index == len(places) - 2 else out / 2)
    largest = min(room) / math.tan(half)
    if drive.min_turn_radius:
        return _Corner(angle, _require_room(corner, largest, drive))
    radius = min(largest, CUT_M / (1 / math.cos(half) - 1) if half < math.pi / 2 else 0.0)
    return _Corner(angle, radius if radius >= drive.geometry.track / 2 else 0.0)


def _bend_to(start: Pose, point: Point, radius: float) -> Piece:
    """Return the arc after which the robot drives straight to a point.

    The line touches the circle on the side of the point. Seen from the centre of the circle, the point is in the
    direction a at the distance d, so the line has the length l = √(d² - r²), and the arc ends at a + atan2(r, l).
    """
    ahead, left = start.to_local(*point)
    side = math.copysign(1.0, left)
    distance = math.hypot(ahead, abs(left) - radius)
    if distance < radius:
        raise _build_too_near_error(start, point, radius)
    direction = math.atan2(abs(left) - radius, ahead)
    turned = (direction + math.atan2(radius, math.sqrt(distance**2 - radius**2))) % math.tau
    is_straight = min(turned, math.tau - turned) < 1e-6
    return Piece(start, 0.0 if is_straight else radius * turned, side / radius)


def _drop_repetitions(start: Point, points: Sequence[Point]) -> Iterator[Point]:
    yield start
    last = start
    for point in points:
        if math.dist(last, point) >= SAME_M:
            yield point
            last = point


def _require_room(corner: Point, largest: float, drive: DifferentialDrive) -> float:
    radius = RADIUS_FACTOR * drive.min_turn_radius
    if radius > largest:
        raise UsageError(
            f"the corner of the path at ({corner[0]:g}, {corner[1]:g}) has room for an arc of {largest:.2f} m radius, "
            f"but the robot steers, and needs {radius:.2f} m. Move the points apart, or make the corner less sharp",
            kind="turn-too-sharp",
            x_m=corner[0],
            y_m=corner[1],
        )
    return radius


def _build_too_near_error(start: Pose, point: Point, radius: float) -> UsageError:
    return UsageError(
        f"the robot steers, and cannot reach the point ({point[0]:g}, {point[1]:g}) from ({start.x:.2f}, "
        f"{start.y:.2f}): it lies inside of its turning circle of {radius:.2f} m radius. Drive away from it first, "
        "with straight",
        kind="point-too-near",
        x_m=point[0],
        y_m=point[1],
    )

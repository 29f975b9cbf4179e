"""Draw a world and the track of a robot from above. North is up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import cv2
import numpy as np

from robotcore.canvas import INK, PAPER, Canvas, Colour, Point, darken, lighten
from robotcore.description import Ball, Light, RobotDescription, WorldDescription
from robotcore.description.world import Prism
from robotcore.geometry import Pose
from robotcore.optics import Image


class TrackPoint(NamedTuple):
    """The robot's pose and the app's state in one tick. The time is in seconds."""

    time: float
    state: str
    pose: Pose


class Track:
    """The poses and states of a run, one point for each tick.

    >>> track = Track()
    >>> track.points += [TrackPoint(t, state, Pose(t, 0, 0)) for t, state in ((0.0, "search"), (1.0, "seen"))]
    >>> list(track.list_state_durations())
    [('search', 0.0, 0.0), ('seen', 1.0, 1.0)]
    """

    def __init__(self) -> None:
        self.points: list[TrackPoint] = []
        """The points, from the first tick to the last."""
        self.is_located = True
        """Whether the robot's poses are known. If False, the pose of each point is the origin, and is not drawn."""

    @property
    def states(self) -> list[str]:
        """The states in the order of their first occurrence."""
        return list(dict.fromkeys(step.state for step in self.points))

    def list_segments(self) -> Iterator[tuple[str, list[TrackPoint]]]:
        """Yield the state and the points of each period in which the state did not change.

        A segment also has the last point of the previous segment, so that the drawn line has no gaps.
        """
        last: list[TrackPoint] = []
        for state, steps in groupby(self.points, key=lambda step: step.state):
            segment = [*last, *steps]
            yield state, segment
            last = segment[-1:]

    def list_state_durations(self) -> Iterator[tuple[str, float, float]]:
        """Yield each state, the time when the app first entered it, and its total duration, both in seconds."""
        for state in self.states:
            segments = [steps for name, steps in self.list_segments() if name == state]
            first = next(step.time for step in segments[0] if step.state == state)
            yield state, first, sum(steps[-1].time - steps[0].time for steps in segments)

    def find_milestone_poses(self, milestones: Mapping[str, float]) -> dict[str, Pose]:
        """Return the robot's pose at each milestone that is also a state.

        milestones: the time of each milestone, in seconds.
        """
        states = set(self.states)
        return {
            name: min(self.points, key=lambda step: abs(step.time - time)).pose
            for name, time in milestones.items()
            if name in states
        }


MARGIN_M = 0.12
"""The margin around the map, in metres."""

ROBOT_MARGIN_M = 0.2
"""The margin around a path that leaves the floor, in metres."""


@dataclass(frozen=True)
class MapTransform:
    """The transform from metres in the world to pixels of a canvas.

    >>> MapTransform(scale=100.0, origin=(400.0, 400.0)).to_pixel(1.0, 2.0)
    (500.0, 200.0)
    """

    scale: float
    """Pixels per metre."""

    origin: Point
    """The pixel at which the world's origin is drawn."""

    @classmethod
    def fit(cls, world: WorldDescription, points: Sequence[TrackPoint], size: float) -> MapTransform:
        """Return the transform for a square canvas that shows the floor, its walls and all points.

        size: the side of the canvas, in pixels.
        """
        wall = world.walls.thickness_m if world.walls else 0.0
        edge = max(world.floor.length_m, world.floor.width_m) / 2 + wall
        farthest = max((max(abs(step.pose.x), abs(step.pose.y)) for step in points), default=0.0)
        reach = max(edge, farthest + ROBOT_MARGIN_M) + MARGIN_M
        return cls(size / 2 / reach, (size / 2, size / 2))

    def to_pixel(self, x: float, y: float) -> Point:
        """Return the pixel of a point of the world, which is given in metres."""
        return self.origin[0] + x * self.scale, self.origin[1] - y * self.scale

    def to_pixels(self, points: Sequence[tuple[float, float]]) -> list[Point]:
        """Return the pixels of points of the world, which are given in metres."""
        return [self.to_pixel(x, y) for x, y in points]


class MapPath(NamedTuple):
    """The path of a robot on a map."""

    robot: RobotDescription
    track: Track
    milestones: Mapping[str, float]
    """The time of each milestone, in seconds."""
    colours: Mapping[str, Colour]
    """The colour of each state."""


def draw_map(world: WorldDescription, paths: Sequence[MapPath], size: int) -> Image:
    """Return the map of a world with the paths of robots: BGR, ``size`` pixels wide and high.

    A path is narrower than the path before it, so that paths at the same place do not hide each other.
    """
    canvas = Canvas(size, size, PAPER)
    transform = MapTransform.fit(world, [step for path in paths for step in path.track.points], size)
    _draw_world(canvas, transform, world)
    paths = [path for path in paths if path.track.points and path.track.is_located]
    width = max(2.0, 0.028 * transform.scale)
    widths = [width * 2.2**narrower for narrower in reversed(range(len(paths)))]
    for path in paths:
        _draw_start(canvas, transform, path.robot, path.track.points[0].pose)
    for path in paths:
        _draw_line(canvas, transform, path.track.points, PAPER, widths[0] + 4)
    for path, path_width in zip(paths, widths, strict=True):
        for state, steps in path.track.list_segments():
            _draw_line(canvas, transform, steps, path.colours[state], path_width)
    for path in paths:
        _draw_robot(canvas, transform, path.robot, path.track.points[-1].pose)
    _draw_milestones(canvas, transform, paths)
    return canvas.render()


def _draw_world(canvas: Canvas, transform: MapTransform, world: WorldDescription) -> None:
    """Draw the floor with its grid, picture and lines, the obstacles with their shadows, and the targets."""
    _draw_floor(canvas, transform, world)
    shadows = [_compute_shadow_outline(prism, world) for prism in world.prisms]
    canvas.draw_shadow([transform.to_pixels(shadow) for shadow in shadows], 0.28, 0.015 * transform.scale)
    for prism in world.prisms:
        outline = transform.to_pixels(prism.outline)
        canvas.fill_polygon(outline, prism.colour)
        canvas.draw_line(outline, darken(prism.colour, 0.72), 1.5, closed=True)
    for ball in world.targets:
        _draw_ball(canvas, transform, ball, world.light)


def _draw_line(
    canvas: Canvas, transform: MapTransform, steps: Sequence[TrackPoint], colour: Colour, width: float
) -> None:
    canvas.draw_line(transform.to_pixels([(step.pose.x, step.pose.y) for step in steps]), colour, width)


def _draw_milestones(canvas: Canvas, transform: MapTransform, paths: Sequence[MapPath]) -> None:
    """Draw a ring at each milestone's pose. A ring that would hide another one is moved to the right."""
    radius = 0.045 * transform.scale
    rings: list[Point] = []
    for path in paths:
        for name, place in path.track.find_milestone_poses(path.milestones).items():
            x, y = transform.to_pixel(place.x, place.y)
            while any(math.dist((x, y), ring) < 1.6 * radius for ring in rings):
                x += 1.6 * radius
            rings.append((x, y))
            draw_ring(canvas, (x, y), radius, path.colours[name])


def draw_ring(canvas: Canvas, centre: Point, radius: float, colour: Colour) -> None:
    """Draw the ring that marks a milestone."""
    for share, filling in ((1.0, INK), (0.8, PAPER), (0.45, colour)):
        canvas.fill_circle(centre, radius * share, filling)


def _draw_start(canvas: Canvas, transform: MapTransform, robot: RobotDescription, pose: Pose) -> None:
    canvas.draw_line(_place_shape(transform, pose, robot.body.footprint), INK, 1.5, closed=True)
    canvas.draw_line(_place_shape(transform, pose, _build_arrow(robot)), INK, 1.5)


def _draw_robot(canvas: Canvas, transform: MapTransform, robot: RobotDescription, pose: Pose) -> None:
    footprint = _place_shape(transform, pose, robot.body.footprint)
    canvas.draw_shadow([footprint], 0.4, 0.02 * transform.scale)
    canvas.fill_polygon(footprint, robot.body.colour)
    canvas.draw_line(footprint, PAPER, 2.0, closed=True)
    for wheel in _build_wheels(robot):
        canvas.fill_polygon(_place_shape(transform, pose, wheel), INK)
    canvas.draw_line(_place_shape(transform, pose, _build_arrow(robot)), PAPER, 2.5)


def _draw_floor(canvas: Canvas, transform: MapTransform, world: WorldDescription) -> None:
    x, y = world.floor.length_m / 2, world.floor.width_m / 2
    width, height = canvas.width, canvas.height
    canvas.fill_polygon([(0, 0), (width, 0), (width, height), (0, height)], lighten(world.floor.colour, 0.4))
    canvas.fill_polygon(transform.to_pixels([(x, y), (-x, y), (-x, -y), (x, -y)]), world.floor.colour)
    grid = lighten(world.floor.colour, 0.25)
    for metre in range(-int(x), int(x) + 1):
        canvas.draw_line(transform.to_pixels([(metre, -y), (metre, y)]), grid, 1)
    for metre in range(-int(y), int(y) + 1):
        canvas.draw_line(transform.to_pixels([(-x, metre), (x, metre)]), grid, 1)
    if image := world.floor.image:
        left, bottom, right, top = image.limits
        corners = transform.to_pixel(left, top), transform.to_pixel(right, bottom)
        canvas.draw_picture(image.render(world.floor.colour)[:, :, ::-1], *corners)
    for line in world.lines:
        for outline in line.outlines:
            canvas.fill_polygon(transform.to_pixels(outline), line.colour)


def _draw_ball(canvas: Canvas, transform: MapTransform, ball: Ball, light: Light) -> None:
    (x, y), radius = transform.to_pixel(ball.x_m, ball.y_m), ball.radius_m * transform.scale
    east, north = math.cos(light.azimuth_rad), math.sin(light.azimuth_rad)
    away = ball.radius_m * math.cos(light.elevation_rad)
    shadow_x, shadow_y = transform.to_pixel(ball.x_m - away * east, ball.y_m - away * north)
    canvas.draw_shadow([[(shadow_x + radius * a, shadow_y + radius * b) for a, b in _CIRCLE]], 0.35, radius * 0.15)
    canvas.fill_circle((x, y), radius, darken(ball.colour, 0.8))
    canvas.fill_circle((x, y), radius * 0.9, ball.colour)
    canvas.fill_circle((x + east * radius * 0.4, y - north * radius * 0.4), radius * 0.22, lighten(ball.colour, 0.6))


_CIRCLE = [(math.cos(turn * math.tau / 48), math.sin(turn * math.tau / 48)) for turn in range(48)]


def _compute_shadow_outline(prism: Prism, world: WorldDescription) -> list[tuple[float, float]]:
    x, y, z = world.light.direction
    foot = np.array(prism.outline, np.float32)
    top = foot - np.array((x, y), np.float32) * np.float32(prism.height_m / z)
    hull = cv2.convexHull(np.concatenate((foot, top)))
    return [(float(corner[0]), float(corner[1])) for corner in hull[:, 0]]


def _place_shape(transform: MapTransform, pose: Pose, shape: Sequence[tuple[float, float]]) -> list[Point]:
    return transform.to_pixels([pose.to_world(x, y) for x, y in shape])


def _build_arrow(robot: RobotDescription) -> list[tuple[float, float]]:
    """Return the corners of an arrow that points forward, in the robot's frame, in metres."""
    front, half = robot.body.front_x_m, robot.body.width_m / 4
    return [(front * 0.45, half), (front * 0.8, 0.0), (front * 0.45, -half)]


def _build_wheels(robot: RobotDescription) -> list[list[tuple[float, float]]]:
    if (drive := robot.drive) is None:
        return []
    a, b = drive.wheel_radius_m, drive.wheel_width_m / 2
    return [
        [(x + a, y + b), (x - a, y + b), (x - a, y - b), (x + a, y - b)]
        for x, y in ((wheel.x_m, wheel.y_m) for wheel in drive.wheels)
    ]

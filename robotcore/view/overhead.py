"""Draw a world and the track of a robot from above. North is up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import cv2
import numpy as np

from robotcore.description import Ball, Light, RobotDescription, WorldDescription
from robotcore.description.world import Prism
from robotcore.geometry import Pose
from robotcore.view.canvas import INK, PAPER, Canvas, Colour, Point, darken, lighten


class TrackPoint(NamedTuple):
    """The robot's pose and the app's state in one tick."""

    time: float
    """The time of the tick, in seconds."""

    state: str
    """The state of the app."""

    pose: Pose
    """The pose of the robot."""


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

    def __repr__(self) -> str:
        return f"<Track of {len(self.points)} points, states {', '.join(self.states) or 'none'}>"

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
    def fit(cls, world: WorldDescription, track: Track, size: float) -> MapTransform:
        """Return the transform for a square canvas that shows the floor, its walls and the whole track.

        size: the side of the canvas, in pixels.
        """
        wall = world.walls.thickness_m if world.walls else 0.0
        edge = max(world.floor.length_m, world.floor.width_m) / 2 + wall
        farthest = max((max(abs(step.pose.x), abs(step.pose.y)) for step in track.points), default=0.0)
        reach = max(edge, farthest + ROBOT_MARGIN_M) + MARGIN_M
        return cls(size / 2 / reach, (size / 2, size / 2))

    def to_pixel(self, x: float, y: float) -> Point:
        """Return the pixel of a point of the world, which is given in metres."""
        return self.origin[0] + x * self.scale, self.origin[1] - y * self.scale

    def to_pixels(self, points: Sequence[tuple[float, float]]) -> list[Point]:
        """Return the pixels of points of the world, which are given in metres."""
        return [self.to_pixel(x, y) for x, y in points]


def draw_world(canvas: Canvas, transform: MapTransform, world: WorldDescription) -> None:
    """Draw the floor with a grid line for each metre, the obstacles with their shadows, and the targets."""
    _draw_floor(canvas, transform, world)
    shadows = [_compute_shadow_outline(prism, world) for prism in world.prisms]
    canvas.draw_shadow([transform.to_pixels(shadow) for shadow in shadows], 0.28, 0.015 * transform.scale)
    for prism in world.prisms:
        outline = transform.to_pixels(prism.outline)
        canvas.fill_polygon(outline, prism.colour)
        canvas.draw_line(outline, darken(prism.colour, 0.72), 1.5, closed=True)
    for ball in world.targets:
        _draw_ball(canvas, transform, ball, world.light)


def draw_track(canvas: Canvas, transform: MapTransform, track: Track, colours: Mapping[str, Colour]) -> None:
    """Draw the path of the robot. Each segment has the colour of its state."""
    width = max(2.0, 0.028 * transform.scale)
    points = [transform.to_pixel(step.pose.x, step.pose.y) for step in track.points]
    canvas.draw_line(points, PAPER, width + 4)
    for state, steps in track.list_segments():
        canvas.draw_line([transform.to_pixel(step.pose.x, step.pose.y) for step in steps], colours[state], width)


def draw_milestones(
    canvas: Canvas, transform: MapTransform, places: Mapping[str, Pose], colours: Mapping[str, Colour]
) -> None:
    """Draw a ring at each milestone's pose. A ring that would hide another one is moved to the right."""
    radius = 0.045 * transform.scale
    rings: list[Point] = []
    for name, place in places.items():
        x, y = transform.to_pixel(place.x, place.y)
        while any(math.dist((x, y), ring) < 1.6 * radius for ring in rings):
            x += 1.6 * radius
        rings.append((x, y))
        draw_ring(canvas, (x, y), radius, colours[name])


def draw_ring(canvas: Canvas, centre: Point, radius: float, colour: Colour) -> None:
    """Draw the ring that marks a milestone."""
    for share, filling in ((1.0, INK), (0.8, PAPER), (0.45, colour)):
        canvas.fill_circle(centre, radius * share, filling)


def draw_start(canvas: Canvas, transform: MapTransform, robot: RobotDescription, pose: Pose) -> None:
    """Draw the outline of the robot at its first pose."""
    canvas.draw_line(_place_shape(transform, pose, robot.body.footprint), INK, 1.5, closed=True)
    canvas.draw_line(_place_shape(transform, pose, _build_arrow(robot)), INK, 1.5)


def draw_robot(canvas: Canvas, transform: MapTransform, robot: RobotDescription, pose: Pose) -> None:
    """Draw the robot's body, its wheels and an arrow that points forward."""
    footprint = _place_shape(transform, pose, robot.body.footprint)
    canvas.draw_shadow([footprint], 0.4, 0.02 * transform.scale)
    canvas.fill_polygon(footprint, robot.body.colour)
    canvas.draw_line(footprint, PAPER, 2.0, closed=True)
    for wheel in _build_wheels(robot):
        canvas.fill_polygon(_place_shape(transform, pose, wheel), INK)
    canvas.draw_line(_place_shape(transform, pose, _build_arrow(robot)), PAPER, 2.5)


def _draw_floor(canvas: Canvas, transform: MapTransform, world: WorldDescription) -> None:
    x, y = world.floor.length_m / 2, world.floor.width_m / 2
    canvas.fill_polygon(_list_corners(canvas), lighten(world.floor.colour, 0.4))
    canvas.fill_polygon(transform.to_pixels([(x, y), (-x, y), (-x, -y), (x, -y)]), world.floor.colour)
    line = lighten(world.floor.colour, 0.25)
    for metre in range(-int(x), int(x) + 1):
        canvas.draw_line(transform.to_pixels([(metre, -y), (metre, y)]), line, 1)
    for metre in range(-int(y), int(y) + 1):
        canvas.draw_line(transform.to_pixels([(-x, metre), (x, metre)]), line, 1)


def _list_corners(canvas: Canvas) -> list[Point]:
    return [(0, 0), (canvas.width, 0), (canvas.width, canvas.height), (0, canvas.height)]


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
        [(a, side + b), (-a, side + b), (-a, side - b), (a, side - b)]
        for side in (drive.track_m / 2, -drive.track_m / 2)
    ]

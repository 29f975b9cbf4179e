"""The labelled frames of `benchmarks.detector`. Each frame is drawn from a seed and a number, and is not stored.

A scene is a random world with a ball of random size, which may be partly hidden or absent. Some objects around the ball
have similar colours. The painted camera of the kinematic backend and PyBullet's renderer render the scenes in turns.
"""

from __future__ import annotations

import colorsys
import math
from random import Random
from typing import NamedTuple

import numpy as np

from benchmarks.camera_effects import Conditions, Mask, add_texture, apply_camera_effects
from drivers.kinematic.clearance import Clearance
from robotcore.autonomy.vision import HUES
from robotcore.description import (
    COLOURS,
    Ball,
    Box,
    Mount,
    RobotDescription,
    WorldDescription,
    draw_world,
    hue_degrees,
    load_robot,
    load_world,
)
from robotcore.description.generation.gaps import compute_gap
from robotcore.description.world import Cylinder
from robotcore.geometry import Pose
from robotcore.hal.backend import Setup, load_backend
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import CameraView, Image
from robotcore.simulation.painter import Painter
from robotcore.simulation.rigid_body import BodyCamera

Rgb = tuple[int, int, int]

WORLDS = ("arena", "clutter", "occluded")
DIAMETERS_PX = 4.0, 420.0
APART_DEGREES = 45.0
"""The minimum distance between the hues of the ball and of other objects, in degrees."""

HIDING = 0.3
"""The share of scenes in which a screen hides a part of the ball."""

MIN_VISIBLE_PX = 12
"""The minimum number of visible pixels of a ball. A frame whose ball has fewer is drawn again."""

ABSENT = 0.3
"""The share of frames without a ball."""

GREENS, OTHERS = ("green",) * 6, ("red", "blue", "yellow", "magenta")


class LabelledFrame(NamedTuple):
    """A frame with its label: the hue and the visible pixels of the ball, and whether the conditions are harsh."""

    image: Image
    hue: float
    ball: Mask
    is_hard: bool

    @property
    def has_ball(self) -> bool:
        return bool(self.ball.any())

    @property
    def centroid(self) -> tuple[float, float]:
        """The column and the row of the centroid of the visible pixels."""
        rows, columns = np.nonzero(self.ball)
        return float(columns.mean()), float(rows.mean())

    def holds(self, u: float, v: float) -> bool:
        """Return whether a point (column, row) is within the bounding box of the visible pixels."""
        if not self.has_ball:
            return False
        rows, columns = np.nonzero(self.ball)
        is_beside = u < columns.min() - 0.5 or u > columns.max() + 0.5
        return not (is_beside or v < rows.min() - 0.5 or v > rows.max() + 0.5)


def draw_frame(seed: int, number: int) -> LabelledFrame:
    """Return the frame with a number. Odd numbers have harsh conditions. The renderers alternate."""
    draw = Random(f"eyes/{seed}/{number}")
    is_hard = bool(number % 2)
    hue, has_ball = HUES[draw.choice(GREENS + OTHERS)], draw.random() > ABSENT
    while True:
        scene = _draw_scene(hue, 0.5 if is_hard else 0.1, draw, has_ball=has_ball)
        image, ball, floor = (_render_with_painter if number % 4 < 2 else _render_with_bullet)(scene)
        if not has_ball or ball.sum() >= MIN_VISIBLE_PX:
            break
    if is_hard and draw.random() < 0.3:
        image = add_texture(image, floor, _draw_grass_colour(hue, draw), draw)
    how = Conditions.harsh(draw, scene.diameter_px) if is_hard else Conditions.mild(draw)
    image = apply_camera_effects(image, ball, how, draw)
    image.flags.writeable = False
    return LabelledFrame(image, hue, ball, is_hard)


class _Rendering(NamedTuple):
    """A picture, (height, width, 3), BGR, and the masks of the ball and the floor, (height, width)."""

    image: Image
    ball: Mask
    floor: Mask


def _render_with_painter(scene: Scene) -> _Rendering:
    """Render a scene with the painted camera of the kinematic backend."""
    painter = Painter(scene.world)
    image, labels = painter.picture(scene.view), painter.labels(scene.view)
    is_sky = (image == scene.world.light.sky_colour[::-1]).all(axis=2)
    ball = labels == painter.things.index("ball") + 1 if scene.world.targets else np.zeros(labels.shape, bool)
    return _Rendering(image, ball, (labels == 0) & ~is_sky)


def _render_with_bullet(scene: Scene) -> _Rendering:
    """Render a scene with PyBullet's software renderer."""
    with load_backend("pybullet").open(Setup(load_robot("rover"), scene.world, frozenset({"eye"}))) as opened:
        camera = opened.camera
        assert isinstance(camera, BodyCamera)
        image, numbers = camera.picture(scene.view), camera.segmentation(scene.view)
        things = list(camera.things.values())
        ball = numbers == camera.things.get("ball", len(things) + 99)
        return _Rendering(image, ball, (numbers >= 0) & ~np.isin(numbers, things))


class Scene(NamedTuple):
    """A world, the camera's view, and the diameter of the whole ball in pixels, if there is one."""

    world: WorldDescription
    view: CameraView
    diameter_px: float


def _draw_scene(hue: float, likeness: float, draw: Random, *, has_ball: bool) -> Scene:
    """Return a random scene.

    hue: the hue of the ball, in degrees.
    likeness: the share of obstacles, from 0 to 1, whose colour is similar.
    """
    robot = load_robot("rover")
    world = draw_world(load_world(draw.choice(WORLDS)), robot, draw.randrange(1_000_000))
    world = _recolour(world, hue, likeness, draw)
    pose = _draw_free_pose(world, robot, draw)
    eye = robot.first_of(CameraDescription)
    assert eye, "the robot has a camera"
    mount = Mount(x_m=eye.mount.x_m, z_m=eye.mount.z_m * draw.uniform(0.7, 1.6), pitch_rad=draw.uniform(-0.06, 0.12))
    view = CameraView.of(eye.intrinsics, mount, pose)
    looking = pose.compose(Pose(mount.x_m, mount.y_m, 0.0))
    if not has_ball:
        return Scene(world.model_copy(update={"targets": ()}), view, 0.0)
    colour = _make_colour(hue + draw.uniform(-8, 8), draw.uniform(0.65, 0.95), draw.uniform(0.5, 0.9))
    ball, diameter = _draw_ball(view, looking, colour, draw)
    world = world.model_copy(update={"targets": (ball,)})
    if draw.random() < HIDING:
        world = _add_screen(world, ball, looking, draw)
    return Scene(world, view, diameter)


def _draw_free_pose(world: WorldDescription, robot: RobotDescription, draw: Random) -> Pose:
    """Return a random pose that is free of obstacles, and faces roughly to the middle of the room."""
    surroundings = Clearance(robot.body.footprint, world)
    x, y = world.floor.length_m / 2, world.floor.width_m / 2
    while True:
        place = Pose(draw.uniform(-x, x), draw.uniform(-y, y), 0.0)
        pose = place._replace(heading=place.bearing_to(0.0, 0.0) + draw.uniform(-1.0, 1.0))
        if surroundings.measure_gaps(pose).min() > 0:
            return pose


def _draw_ball(view: CameraView, eye: Pose, colour: Rgb, draw: Random) -> tuple[Ball, float]:
    low, high = map(math.log, DIAMETERS_PX)
    diameter = math.exp(draw.uniform(low, high))
    focal = view.intrinsics.focal_length
    radius = draw.uniform(0.06, 0.12) if diameter > 30 else draw.uniform(0.012, 0.05)
    away = max(2 * radius * focal / diameter, 1.15 * radius)
    across = math.radians(31) * draw.uniform(-1.1, 1.1)
    x, y = eye.to_world(away * math.cos(across), away * math.sin(across))
    return Ball(name="ball", radius_m=radius, colour=colour, x_m=x, y_m=y), 2 * radius * focal / away


def _add_screen(world: WorldDescription, ball: Ball, eye: Pose, draw: Random) -> WorldDescription:
    distance, bearing = eye.distance_to(ball.x_m, ball.y_m), eye.bearing_to(ball.x_m, ball.y_m)
    length, side = draw.uniform(0.05, 0.3), draw.choice((-1, 1))
    towards = eye._replace(heading=eye.heading + bearing)
    part = draw.uniform(0.5, 0.85)
    aside = side * (length / 2 + part * ball.radius_m * draw.uniform(-0.6, 0.9))
    x, y = towards.to_world(part * distance, aside)
    screen = Box(
        shape="box",
        name="screen",
        colour=draw.choice(world.obstacles).colour,
        x_m=x,
        y_m=y,
        yaw_rad=towards.heading + math.pi / 2,
        length_m=length,
        width_m=0.02,
        height_m=draw.uniform(0.1, 0.3),
    )
    is_apart = all(compute_gap(screen.outline, thing.outline) > 0.005 for thing in (*world.prisms, ball))
    return world.model_copy(update={"obstacles": (*world.obstacles, screen)}) if is_apart else world


def _make_colour(hue: float, saturation: float, value: float) -> Rgb:
    """Return a colour as red, green and blue. The hue is in degrees, saturation and value are from 0 to 1."""
    red, green, blue = (round(255 * part) for part in colorsys.hsv_to_rgb(hue % 360 / 360, saturation, value))
    return red, green, blue


def _draw_similar_colour(hue: float, draw: Random) -> Rgb:
    """Draw a colour that is similar to a hue. For green: yellow-green, cyan, olive, or the colour of a pale wall."""
    neighbour = _make_colour(
        hue + draw.choice((-1, 1)) * draw.uniform(48, 75), draw.uniform(0.5, 0.95), draw.uniform(0.35, 0.95)
    )
    olive = _make_colour(hue - draw.uniform(45, 65), draw.uniform(0.4, 0.8), draw.uniform(0.25, 0.5))
    pale = _make_colour(hue + draw.uniform(-20, 20), draw.uniform(0.08, 0.22), draw.uniform(0.5, 0.9))
    return draw.choice((neighbour, neighbour, olive, pale))


def _draw_grass_colour(hue: float, draw: Random) -> Rgb:
    """Draw the mean colour of a lawn, which is duller and yellower than a green ball."""
    return _make_colour(hue - draw.uniform(22, 42), draw.uniform(0.25, 0.5), draw.uniform(0.3, 0.65))


def _recolour(world: WorldDescription, hue: float, likeness: float, draw: Random) -> WorldDescription:
    """Return the world with new colours of obstacles, so that only the ball has the hue.

    likeness: the share of obstacles, from 0 to 1, whose colour is similar to the hue.
    """

    def paint(obstacle: Box | Cylinder) -> Box | Cylinder:
        if draw.random() < likeness:
            return obstacle.model_copy(update={"colour": _draw_similar_colour(hue, draw)})
        if _are_alike(obstacle.colour, hue):
            return obstacle.model_copy(update={"colour": COLOURS["grey"]})
        return obstacle

    return world.model_copy(update={"obstacles": tuple(paint(obstacle) for obstacle in world.obstacles)})


def _are_alike(colour: Rgb, hue: float) -> bool:
    is_coloured = max(colour) - min(colour) > 0.25 * max(colour)
    return is_coloured and abs((hue_degrees(colour) - hue + 180) % 360 - 180) < APART_DEGREES

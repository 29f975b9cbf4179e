"""The labelled frames. Each frame is drawn from a seed and a number, and is not stored.

The painted camera of the kinematic backend and PyBullet's renderer render them in turns.
"""

from __future__ import annotations

from random import Random
from typing import NamedTuple

import numpy as np

from benchmarks.eyes.effects import Conditions, Mask, add_texture, apply_camera_effects
from benchmarks.eyes.scenes import Scene, draw_grass_colour, draw_scene
from drivers.pybullet.sensors import BulletCamera
from robotcore.autonomy.vision import HUES
from robotcore.description import load_robot
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.devices import Image
from robotcore.simulation.painter import Painter

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
        scene = draw_scene(hue, 0.5 if is_hard else 0.1, draw, has_ball=has_ball)
        image, ball, floor = (_render_with_painter if number % 4 < 2 else _render_with_bullet)(scene)
        if not has_ball or ball.sum() >= MIN_VISIBLE_PX:
            break
    if is_hard and draw.random() < 0.3:
        image = add_texture(image, floor, draw_grass_colour(hue, draw), draw)
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
        assert isinstance(camera, BulletCamera)
        image, numbers = camera.picture(scene.view), camera.segmentation(scene.view)
        things = list(camera.things.values())
        ball = numbers == camera.things.get("ball", len(things) + 99)
        return _Rendering(image, ball, (numbers >= 0) & ~np.isin(numbers, things))

"""The labelled frames. Each frame is drawn from a seed and a number, and is not stored."""

from __future__ import annotations

from random import Random
from typing import NamedTuple

import numpy as np

from benchmarks.eyes.conditions import Conditions
from benchmarks.eyes.optics import add_texture, apply_camera_effects
from benchmarks.eyes.palette import draw_grass_colour
from benchmarks.eyes.rendering import Mask, render_with_bullet, render_with_painter
from benchmarks.eyes.scenes import draw_scene
from robotcore.autonomy.vision import HUES
from robotcore.hal.devices import Image

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
        image, ball, floor = (render_with_painter if number % 4 < 2 else render_with_bullet)(scene)
        if not has_ball or ball.sum() >= MIN_VISIBLE_PX:
            break
    if is_hard and draw.random() < 0.3:
        image = add_texture(image, floor, draw_grass_colour(hue, draw), draw)
    how = Conditions.harsh(draw, scene.diameter_px) if is_hard else Conditions.mild(draw)
    image = apply_camera_effects(image, ball, how, draw)
    image.flags.writeable = False
    return LabelledFrame(image, hue, ball, is_hard)

"""Colours for a ball of one hue and for what stands around it: like it, but not of its hue."""

from __future__ import annotations

import colorsys
from random import Random

from robotcore.description import COLOURS, WorldDescription, hue_degrees
from robotcore.description.world import Box, Cylinder

Rgb = tuple[int, int, int]

APART_DEGREES = 45.0
"""What is nearer in hue than this to the ball is of its colour."""


def rgb(hue: float, saturation: float, value: float) -> Rgb:
    """Return a colour: hue in degrees, saturation and value in 0 to 1."""
    red, green, blue = (round(255 * part) for part in colorsys.hsv_to_rgb(hue % 360 / 360, saturation, value))
    return red, green, blue


def ball_colour(hue: float, draw: Random) -> Rgb:
    """Return a ball's own colour: saturated, and about of the hue that is asked for."""
    return rgb(hue + draw.uniform(-8, 8), draw.uniform(0.65, 0.95), draw.uniform(0.5, 0.9))


def lookalike(hue: float, draw: Random) -> Rgb:
    """Return what may be taken for the hue; beside green: yellow-green, cyan, olive, a pale wall."""
    neighbour = rgb(
        hue + draw.choice((-1, 1)) * draw.uniform(48, 75), draw.uniform(0.5, 0.95), draw.uniform(0.35, 0.95)
    )
    olive = rgb(hue - draw.uniform(45, 65), draw.uniform(0.4, 0.8), draw.uniform(0.25, 0.5))
    pale = rgb(hue + draw.uniform(-20, 20), draw.uniform(0.08, 0.22), draw.uniform(0.5, 0.9))
    return draw.choice((neighbour, neighbour, olive, pale))


def grass(hue: float, draw: Random) -> Rgb:
    """Return a lawn's mean colour, beside green: duller and yellower than a ball."""
    return rgb(hue - draw.uniform(22, 42), draw.uniform(0.25, 0.5), draw.uniform(0.3, 0.65))


def recoloured(world: WorldDescription, hue: float, likeness: float, draw: Random) -> WorldDescription:
    """Return a world where nothing but the ball is of the hue; a part ``likeness`` of the obstacles looks like it."""

    def painted(obstacle: Box | Cylinder) -> Box | Cylinder:
        if draw.random() < likeness:
            return obstacle.model_copy(update={"colour": lookalike(hue, draw)})
        if _are_alike(obstacle.colour, hue):
            return obstacle.model_copy(update={"colour": COLOURS["grey"]})
        return obstacle

    return world.model_copy(update={"obstacles": tuple(painted(obstacle) for obstacle in world.obstacles)})


def _are_alike(colour: Rgb, hue: float) -> bool:
    is_coloured = max(colour) - min(colour) > 0.25 * max(colour)
    return is_coloured and abs((hue_degrees(colour) - hue + 180) % 360 - 180) < APART_DEGREES

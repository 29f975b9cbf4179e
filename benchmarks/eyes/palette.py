"""The colours of a ball and of the objects around it, which look similar but have another hue."""

from __future__ import annotations

import colorsys
from random import Random

from robotcore.description import COLOURS, WorldDescription, hue_degrees
from robotcore.description.world import Box, Cylinder

Rgb = tuple[int, int, int]

APART_DEGREES = 45.0
"""An object whose hue is nearer to the ball's has the colour of the ball."""


def rgb(hue: float, saturation: float, value: float) -> Rgb:
    """Return a colour: hue in degrees, saturation and value in 0 to 1."""
    red, green, blue = (round(255 * part) for part in colorsys.hsv_to_rgb(hue % 360 / 360, saturation, value))
    return red, green, blue


def ball_colour(hue: float, draw: Random) -> Rgb:
    """Return the colour of a ball: saturated, and near the given hue."""
    return rgb(hue + draw.uniform(-8, 8), draw.uniform(0.65, 0.95), draw.uniform(0.5, 0.9))


def lookalike(hue: float, draw: Random) -> Rgb:
    """Return a colour that is similar to the hue; for green, yellow-green, cyan, olive or a pale wall."""
    neighbour = rgb(
        hue + draw.choice((-1, 1)) * draw.uniform(48, 75), draw.uniform(0.5, 0.95), draw.uniform(0.35, 0.95)
    )
    olive = rgb(hue - draw.uniform(45, 65), draw.uniform(0.4, 0.8), draw.uniform(0.25, 0.5))
    pale = rgb(hue + draw.uniform(-20, 20), draw.uniform(0.08, 0.22), draw.uniform(0.5, 0.9))
    return draw.choice((neighbour, neighbour, olive, pale))


def grass(hue: float, draw: Random) -> Rgb:
    """Return the mean colour of a lawn, which is duller and yellower than a green ball."""
    return rgb(hue - draw.uniform(22, 42), draw.uniform(0.25, 0.5), draw.uniform(0.3, 0.65))


def recolour(world: WorldDescription, hue: float, likeness: float, draw: Random) -> WorldDescription:
    """Return a world in which only the ball has the hue. A share ``likeness`` of the obstacles looks similar."""

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

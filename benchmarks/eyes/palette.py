"""The colours of a ball, and the similar colours of the objects around it."""

from __future__ import annotations

import colorsys
from random import Random

from robotcore.description import COLOURS, WorldDescription, hue_degrees
from robotcore.description.world import Box, Cylinder

Rgb = tuple[int, int, int]

APART_DEGREES = 45.0
"""The minimum distance between the hues of the ball and of other objects, in degrees."""


def make_colour(hue: float, saturation: float, value: float) -> Rgb:
    """Return a colour as red, green and blue. The hue is in degrees, saturation and value are from 0 to 1."""
    red, green, blue = (round(255 * part) for part in colorsys.hsv_to_rgb(hue % 360 / 360, saturation, value))
    return red, green, blue


def draw_ball_colour(hue: float, draw: Random) -> Rgb:
    """Draw the colour of a ball: saturated, and near the given hue."""
    return make_colour(hue + draw.uniform(-8, 8), draw.uniform(0.65, 0.95), draw.uniform(0.5, 0.9))


def draw_similar_colour(hue: float, draw: Random) -> Rgb:
    """Draw a colour that is similar to a hue. For green: yellow-green, cyan, olive, or the colour of a pale wall."""
    neighbour = make_colour(
        hue + draw.choice((-1, 1)) * draw.uniform(48, 75), draw.uniform(0.5, 0.95), draw.uniform(0.35, 0.95)
    )
    olive = make_colour(hue - draw.uniform(45, 65), draw.uniform(0.4, 0.8), draw.uniform(0.25, 0.5))
    pale = make_colour(hue + draw.uniform(-20, 20), draw.uniform(0.08, 0.22), draw.uniform(0.5, 0.9))
    return draw.choice((neighbour, neighbour, olive, pale))


def draw_grass_colour(hue: float, draw: Random) -> Rgb:
    """Draw the mean colour of a lawn, which is duller and yellower than a green ball."""
    return make_colour(hue - draw.uniform(22, 42), draw.uniform(0.25, 0.5), draw.uniform(0.3, 0.65))


def recolour(world: WorldDescription, hue: float, likeness: float, draw: Random) -> WorldDescription:
    """Return the world with new colours of obstacles, so that only the ball has the hue.

    likeness: the share of obstacles, from 0 to 1, whose colour is similar to the hue.
    """

    def paint(obstacle: Box | Cylinder) -> Box | Cylinder:
        if draw.random() < likeness:
            return obstacle.model_copy(update={"colour": draw_similar_colour(hue, draw)})
        if _are_alike(obstacle.colour, hue):
            return obstacle.model_copy(update={"colour": COLOURS["grey"]})
        return obstacle

    return world.model_copy(update={"obstacles": tuple(paint(obstacle) for obstacle in world.obstacles)})


def _are_alike(colour: Rgb, hue: float) -> bool:
    is_coloured = max(colour) - min(colour) > 0.25 * max(colour)
    return is_coloured and abs((hue_degrees(colour) - hue + 180) % 360 - 180) < APART_DEGREES

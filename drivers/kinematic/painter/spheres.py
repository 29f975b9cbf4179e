"""Balls in a picture: every pixel asks whether its ray meets the ball, and under which light."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.kinematic.painter.canvas import Canvas, Palette
from drivers.kinematic.planes import Array
from robotcore.description import Ball
from robotcore.projection import View


@dataclass(frozen=True)
class Disc:
    """A ball in the picture: the window that holds it, rows and columns, and which pixels there show it.

    ``cosines`` are of the angle between the ball's surface and the lamp, of no meaning off the ball.
    """

    window: tuple[slice, slice]
    is_hit: NDArray[np.bool_]
    cosines: Array
    part: int

    @property
    def columns(self) -> tuple[float, float]:
        return self.window[1].start, self.window[1].stop - 1

    def paint(self, canvas: Canvas, palette: Palette) -> None:
        ramp = palette.balls[self.part]
        shades = np.clip(self.cosines[self.is_hit], 0.0, 1.0) * (len(ramp) - 1)
        canvas[self.window][self.is_hit] = ramp[shades.astype(np.intp)]


def disc_of(ball: Ball, view: View, lamp: Array, part: int) -> Disc | None:
    """Return how a ball appears, lit from the direction ``lamp``, (3,); None where it is out of the picture.

    A ray d from the eye meets a ball at c where (d·c)² ≥ (|c|² - r²)|d|² and d·c > 0: a conic in the picture.
    """
    centre = view.to_camera(np.array(((ball.x_m, ball.y_m, ball.radius_m),)))[0]
    columns, rows = _window(view, centre, ball.radius_m)
    if centre[2] <= -ball.radius_m or columns.start >= columns.stop or rows.start >= rows.stop:
        return None
    i = view.intrinsics
    right = (np.arange(columns.start, columns.stop) - i.cx) / i.focal_length
    down = ((np.arange(rows.start, rows.stop) - i.cy) / i.focal_length)[:, None]
    light = view.rotation @ lamp
    squared = right**2 + (down**2 + 1)
    to_centre = right * centre[0] + (down * centre[1] + centre[2])
    chord = to_centre**2 - (centre @ centre - ball.radius_m**2) * squared
    is_hit = (chord >= 0) & (to_centre > 0)
    depth = (to_centre - np.sqrt(np.maximum(chord, 0.0))) / squared
    to_light = right * light[0] + (down * light[1] + light[2])
    return Disc((rows, columns), is_hit, (depth * to_light - centre @ light) / ball.radius_m, part)


def _window(view: View, centre: Array, radius: float) -> tuple[slice, slice]:
    """Return the columns and the rows that hold a ball at ``centre`` in camera coordinates."""
    i = view.intrinsics
    right, down, forward = centre.tolist()
    columns = _pixels(_extent(right, forward, radius), i.focal_length, i.cx, i.width)
    rows = _pixels(_extent(down, forward, radius), i.focal_length, i.cy, i.height)
    return columns, rows


def _extent(across: float, forward: float, radius: float) -> tuple[float, float]:
    """Return the slopes of the two planes through the eye that touch a ball from either side.

    From |across - m·forward| = radius·√(1 + m²).
    """
    ahead = forward**2 - radius**2
    if forward <= radius:
        return -math.inf, math.inf
    half = radius * math.sqrt(across**2 + ahead)
    return (across * forward - half) / ahead, (across * forward + half) / ahead


def _pixels(slopes: tuple[float, float], focal_length: float, middle: float, size: int) -> slice:
    low, high = (min(max(slope * focal_length + middle, -1.0), float(size)) for slope in slopes)
    return slice(max(math.ceil(low), 0), min(math.floor(high) + 1, size))

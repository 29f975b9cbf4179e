"""Paint balls: compute for each pixel whether its ray meets the ball, and the light at that point."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Ball
from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter.canvas import Palette, PixelBuffer
from robotcore.simulation.painter.planes import Array

BAND_ROWS = 32
"""The greatest number of rows of a `Band`. It is so small that a band's arrays stay in the processor's cache."""


class Band(NamedTuple):
    """A stroke with up to `BAND_ROWS` rows of a ball."""

    window: tuple[slice, slice]
    """The rectangle of the picture that contains the band."""
    is_hit: NDArray[np.bool_]
    """Whether each pixel of the window shows the ball."""
    cosines: NDArray[np.float32]
    """The cosine of the angle between the ball's normal and the direction to the lamp, for each pixel of the window."""
    part: int
    """The number of the ball."""

    @property
    def columns(self) -> tuple[float, float]:
        return self.window[1].start, self.window[1].stop - 1

    def paint(self, canvas: PixelBuffer, palette: Palette) -> None:
        ramp = palette.balls[self.part]
        steps = np.minimum(np.maximum(self.cosines, 0), 1) * (len(ramp) - 1)
        np.copyto(canvas[self.window], ramp.take(steps.astype(np.intp)), where=self.is_hit)


class _Rays(NamedTuple):
    """The rays through the pixels of a camera, in its frame. The third component of each is 1."""

    right: Array
    """The first component of the rays of each column, (width,)."""
    down: Array
    """The second component of the rays of each row, (height, 1)."""
    right_squared: Array
    """The square of ``right``, (width,)."""
    rest_squared: Array
    """The sum of the squares of the other two components, (height, 1)."""


@lru_cache(maxsize=4)
def _compute_rays(lens: Intrinsics) -> _Rays:
    right: Array = (np.arange(lens.width, dtype=np.float64) - lens.cx) / lens.focal_length
    down: Array = (np.arange(lens.height, dtype=np.float64)[:, None] - lens.cy) / lens.focal_length
    return _Rays(right, down, right**2, down**2 + 1)


class Sphere(NamedTuple):
    """A ball in the camera's frame."""

    centre: list[float]
    radius: float
    lamp: list[float]
    """The direction to the lamp."""
    squared_tangent: float
    """The square of the distance from the camera to the points at which rays touch the ball."""
    centre_to_lamp: float
    """The scalar product of the centre and the direction to the lamp."""
    part: int
    """The number of the ball."""

    @classmethod
    def from_ball(cls, ball: Ball, view: CameraView, lamp: Array, part: int) -> Sphere:
        """Convert a ball of the world to a camera's frame.

        lamp: the direction to the lamp in the world, (3,).
        part: the number of the ball.
        """
        centre, radius = view.to_camera(np.array(((ball.x_m, ball.y_m, ball.radius_m),)))[0], ball.radius_m
        to_lamp, tangent = view.rotation @ lamp, float(centre @ centre) - radius**2
        return cls(centre.tolist(), radius, to_lamp.tolist(), tangent, float(centre @ to_lamp), part)

    def bands(self, lens: Intrinsics) -> Iterator[Band]:
        """Yield the bands that show the ball in the picture, from top to bottom."""
        right, down, forward = self.centre
        if forward <= -self.radius:
            return
        columns = _to_pixels(_compute_slopes(right, forward, self.radius), lens.focal_length, lens.cx, lens.width)
        rows = _to_pixels(_compute_slopes(down, forward, self.radius), lens.focal_length, lens.cy, lens.height)
        for top in rows[::BAND_ROWS] if columns else ():
            window = slice(top, min(top + BAND_ROWS, rows.stop)), slice(columns.start, columns.stop)
            yield self._compute_band(_compute_rays(lens), window)

    def _compute_band(self, rays: _Rays, window: tuple[slice, slice]) -> Band:
        """Intersect the rays of a window's pixels with the ball.

        The ball has the centre c and the radius r. A ray d from the camera meets the ball if
        (d·c)² ≥ (|c|² - r²)|d|² and d·c > 0. The point is t·d with t = (d·c - √((d·c)² - (|c|² - r²)|d|²)) / |d|².
        The normal at this point is (t·d - c) / r.
        """
        (rows, columns), (c_right, c_down, c_forward), (l_right, l_down, l_forward) = window, self.centre, self.lamp
        right, down = rays.right[columns], rays.down[rows]
        squared = rays.right_squared[columns] + rays.rest_squared[rows]
        to_centre = right * c_right + (down * c_down + c_forward)
        to_lamp = right * l_right + (down * l_down + l_forward)
        chord = to_centre**2 - self.squared_tangent * squared
        depth = (to_centre - np.sqrt(np.abs(chord))) / squared
        cosines = (depth * to_lamp - self.centre_to_lamp) / self.radius
        return Band(window, (chord >= 0) & (to_centre > 0), cosines.astype(np.float32), self.part)


def _compute_slopes(across: float, forward: float, radius: float) -> tuple[float, float]:
    """Return the slopes of the two planes through the camera that touch a ball.

    across, forward: the centre of the ball, perpendicular to and along the optical axis.

    The slopes m are the solutions of |across - m·forward| = radius·√(1 + m²).
    """
    ahead = forward**2 - radius**2
    if forward <= radius:
        return -math.inf, math.inf
    half = radius * math.sqrt(across**2 + ahead)
    return (across * forward - half) / ahead, (across * forward + half) / ahead


def _to_pixels(slopes: tuple[float, float], focal_length: float, middle: float, size: int) -> range:
    low, high = (min(max(slope * focal_length + middle, -1.0), float(size)) for slope in slopes)
    return range(max(math.ceil(low), 0), min(math.floor(high) + 1, size))

"""Paints balls. For each pixel it computes if the ray meets the ball, and the light there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Ball
from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter.canvas import Canvas, Palette
from robotcore.simulation.painter.planes import Array

BAND_ROWS = 32
"""A ball is painted in bands, so that the arrays stay in the processor's cache."""


@dataclass(frozen=True)
class Band:
    """Some rows of a ball in the picture.

    ``window`` is the part of the picture with these rows. ``is_hit`` says which pixels of the window show the ball.
    ``cosines`` holds for each of these pixels the cosine of the angle between the surface's normal and the lamp.
    """

    window: tuple[slice, slice]
    is_hit: NDArray[np.bool_]
    cosines: NDArray[np.float32]
    part: int

    @property
    def columns(self) -> tuple[float, float]:
        return self.window[1].start, self.window[1].stop - 1

    def paint(self, canvas: Canvas, palette: Palette) -> None:
        ramp = palette.balls[self.part]
        steps = np.clip(self.cosines, 0, 1) * (len(ramp) - 1)
        np.copyto(canvas[self.window], ramp[steps.astype(np.intp)], where=self.is_hit)


@dataclass(frozen=True)
class Sphere:
    """A ball in the camera's frame. ``centre`` is its centre, (3,), and ``lamp`` the direction to the lamp, (3,)."""

    centre: Array
    radius: float
    lamp: Array
    part: int

    @classmethod
    def of(cls, ball: Ball, view: CameraView, lamp: Array, part: int) -> Sphere:
        """Return a ball of the world in a camera's frame. ``lamp`` is the direction to the lamp."""
        centre = view.to_camera(np.array(((ball.x_m, ball.y_m, ball.radius_m),)))[0]
        return cls(centre, ball.radius_m, view.rotation @ lamp, part)

    def bands(self, lens: Intrinsics) -> Iterator[Band]:
        """Yield the bands of the ball in the picture, from top to bottom."""
        right, down, forward = self.centre.tolist()
        if forward <= -self.radius:
            return
        columns = _pixels(_extent(right, forward, self.radius), lens.focal_length, lens.cx, lens.width)
        rows = _pixels(_extent(down, forward, self.radius), lens.focal_length, lens.cy, lens.height)
        for top in rows[::BAND_ROWS] if columns else ():
            yield self._band(lens, range(top, min(top + BAND_ROWS, rows.stop)), columns)

    def _band(self, lens: Intrinsics, rows: range, columns: range) -> Band:
        """Compute the ball in a window.

        A ray d from the eye meets a ball at c where (d·c)² ≥ (|c|² - r²)|d|² and d·c > 0, a conic in the picture, at
        t·d with t = (d·c - √((d·c)² - (|c|² - r²)|d|²)) / |d|². There the surface faces along (t·d - c) / r.
        """
        right = (np.arange(columns.start, columns.stop) - lens.cx) / lens.focal_length
        down = (np.arange(rows.start, rows.stop)[:, None] - lens.cy) / lens.focal_length
        squared = right**2 + (down**2 + 1)
        to_centre = right * self.centre[0] + (down * self.centre[1] + self.centre[2])
        to_lamp = right * self.lamp[0] + (down * self.lamp[1] + self.lamp[2])
        chord = to_centre**2 - (self.centre @ self.centre - self.radius**2) * squared
        depth = (to_centre - np.sqrt(np.abs(chord))) / squared
        window = slice(rows.start, rows.stop), slice(columns.start, columns.stop)
        cosines = (depth * to_lamp - self.centre @ self.lamp) / self.radius
        return Band(window, (chord >= 0) & (to_centre > 0), cosines.astype(np.float32), self.part)


def _extent(across: float, forward: float, radius: float) -> tuple[float, float]:
    """Return the slopes of the two planes through the camera that touch a ball.

    The slopes m are the solutions of |across - m·forward| = radius·√(1 + m²).
    """
    ahead = forward**2 - radius**2
    if forward <= radius:
        return -math.inf, math.inf
    half = radius * math.sqrt(across**2 + ahead)
    return (across * forward - half) / ahead, (across * forward + half) / ahead


def _pixels(slopes: tuple[float, float], focal_length: float, middle: float, size: int) -> range:
    low, high = (min(max(slope * focal_length + middle, -1.0), float(size)) for slope in slopes)
    return range(max(math.ceil(low), 0), min(math.floor(high) + 1, size))

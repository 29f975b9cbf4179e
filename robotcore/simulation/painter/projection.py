"""Project polygons of a world to pixels, and clip them at the near plane of the camera."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.optics import CameraView
from robotcore.simulation.painter.planes import Array, compute_run_starts

Polygon = list[list[float]]

CLIP_M = 1e-9
"""The distance of the near clipping plane from the camera, in metres.

It is so small that a camera sees a wall even while its robot touches the wall.
"""

_BEHIND, _LEFT, _RIGHT, _ABOVE, _BELOW = (1 << bit for bit in range(5))


class PolygonSet:
    """Convex polygons in the world, which are projected together."""

    def __init__(self, loops: Sequence[Array]) -> None:
        """Store the polygons.

        loops: the corners of each polygon in metres, (n, 3).
        """
        self._corners = np.concatenate((np.empty((0, 3)), *loops))
        self._starts = compute_run_starts(map(len, loops))
        self._ends = self._starts + np.array([len(loop) for loop in loops], dtype=np.intp)

    def project(self, view: CameraView, is_turned: NDArray[np.bool_]) -> Iterator[tuple[int, Polygon]]:
        """Yield the number and the corners in pixels of each polygon, unless the whole polygon is outside the picture.

        is_turned: whether each polygon points to the camera. The others are left out.
        """
        if not len(self._starts):
            return
        corners = view.to_camera(self._corners)
        pixels = view.to_pixels(np.maximum(corners, (-np.inf, -np.inf, CLIP_M)))
        sides = _compute_side_bits(view, corners)
        is_outside = np.bitwise_and.reduceat(sides, self._starts) != 0
        is_cut = (np.bitwise_or.reduceat(sides, self._starts) & _BEHIND) != 0
        for number in np.flatnonzero(is_turned & ~is_outside).tolist():
            span = slice(self._starts[number], self._ends[number])
            yield number, _clip_at_near_plane(view, corners[span]) if is_cut[number] else pixels[span].tolist()


def clip(polygon: Sequence[Array], depths: Sequence[float]) -> list[Array]:
    """Clip a convex polygon at depth 0, and return the corners of the part with a depth of 0 or more.

    depths: the depth at each corner of the polygon.

    Source: Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    """
    kept: list[Array] = []
    for i, (here, depth) in enumerate(zip(polygon, depths, strict=True)):
        before = depths[i - 1]
        if before * depth < 0:
            kept.append(polygon[i - 1] + (here - polygon[i - 1]) * (before / (before - depth)))
        if depth >= 0:
            kept.append(here)
    return kept


def _compute_side_bits(view: CameraView, corners: Array) -> NDArray[np.uint8]:
    """Return a bit set for each corner. A bit is set if the corner is beyond that side of the picture.

    corners: points in the camera's frame, (n, 3).
    """
    i = view.intrinsics
    right, down, forward = corners.T
    half_width = i.width / 2 / i.focal_length * forward
    half_height = i.height / 2 / i.focal_length * forward
    bits = (forward < CLIP_M) * _BEHIND
    bits |= (right < -half_width) * _LEFT
    bits |= (right > half_width) * _RIGHT
    bits |= (down < -half_height) * _ABOVE
    bits |= (down > half_height) * _BELOW
    return np.asarray(bits, dtype=np.uint8)


def _clip_at_near_plane(view: CameraView, corners: Array) -> Polygon:
    """Clip a face at the near plane, and return the corners of the rest in pixels.

    corners: the face's corners in the camera's frame, (n, 3).
    """
    ahead = np.array(clip(list(corners), (corners[:, 2] - CLIP_M).tolist()))
    polygon: Polygon = view.to_pixels(ahead).tolist()
    return polygon

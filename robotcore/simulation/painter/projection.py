"""Project polygons of a world to the picture of a camera, and clip them at its near plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter.planes import Array, compute_run_starts
from robotcore.simulation.painter.rasterizing import Area, rasterize

Point = Sequence[float]

CLIP_M = 1e-9
"""The distance of the near clipping plane from the camera, in metres.

It is so small that a camera sees a wall even while its robot touches the wall.
"""

_NEAREST = np.array((-np.inf, -np.inf, CLIP_M))
_SIDE_OFFSETS = np.array(((0.0,), (0.0,), (0.0,), (0.0,), (-CLIP_M,)))


class PolygonSet:
    """Convex polygons in the world, which are projected together."""

    def __init__(self, loops: Sequence[Array]) -> None:
        """Store the polygons.

        loops: the corners of each polygon in metres, (n, 3).
        """
        self._corners = np.asfortranarray(np.concatenate((np.empty((0, 3)), *loops)))
        self._starts = compute_run_starts(map(len, loops))
        self._spans = [slice(start, start + len(loop)) for start, loop in zip(self._starts, loops, strict=True)]

    def project(self, view: CameraView, is_turned: NDArray[np.bool_]) -> Iterator[tuple[int, Area]]:
        """Yield the number and the pixels of each polygon, unless the whole polygon is outside the picture.

        is_turned: whether each polygon points to the camera. The others are left out.
        """
        if not self._spans:
            return
        corners = np.asfortranarray(view.to_camera(self._corners))  # NumPy is faster along a long axis
        pixels = view.to_pixels(np.maximum(corners, _NEAREST)).T
        is_outside, is_cut = self._classify(view, corners)
        width, height = view.intrinsics.width, view.intrinsics.height
        for number in np.flatnonzero(is_turned & ~is_outside).tolist():
            span = self._spans[number]
            polygon = _clip_at_near_plane(view, corners[span]) if is_cut[number] else pixels[:, span]
            us, vs = polygon.tolist()
            yield number, rasterize(us, vs, width, height)

    def _classify(self, view: CameraView, corners: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return whether each polygon is outside the picture, and whether the near plane may cut it, each (n,).

        corners: the corners of all polygons in the camera's frame, (corners, 3).
        """
        is_beyond = _compute_sides(view.intrinsics) @ corners.T > _SIDE_OFFSETS
        # A polygon is outside the picture if all its corners are beyond the same side.
        is_outside = np.logical_or.reduce(np.logical_and.reduceat(is_beyond, self._starts, axis=1), axis=0)
        return is_outside, np.logical_or.reduceat(is_beyond[4], self._starts)


@lru_cache(maxsize=4)
def _compute_sides(lens: Intrinsics) -> Array:
    """Return the outward normals of the planes through the camera and the picture's sides, and of the near plane."""
    left, right = (lens.cx + 0.5) / lens.focal_length, (lens.width - 0.5 - lens.cx) / lens.focal_length
    top, bottom = (lens.cy + 0.5) / lens.focal_length, (lens.height - 0.5 - lens.cy) / lens.focal_length
    return np.array(((-1, 0, -left), (1, 0, -right), (0, -1, -top), (0, 1, -bottom), (0, 0, -1)))


def clip(polygon: Sequence[Point], depths: Sequence[float]) -> list[Point]:
    """Clip a convex polygon at depth 0, and return the corners of the part with a depth of 0 or more.

    depths: the depth at each corner of the polygon.

    Source: Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    """
    kept: list[Point] = []
    for i, (here, depth) in enumerate(zip(polygon, depths, strict=True)):
        before = depths[i - 1]
        if before * depth < 0:
            share = before / (before - depth)
            kept.append([a + (b - a) * share for a, b in zip(polygon[i - 1], here, strict=True)])
        if depth >= 0:
            kept.append(here)
    return kept


def _clip_at_near_plane(view: CameraView, corners: Array) -> Array:
    """Clip a face at the near plane, and return the columns and the rows of the rest's corners in pixels, (2, n).

    corners: the face's corners in the camera's frame, (n, 3).
    """
    ahead = clip(corners.tolist(), (corners[:, 2] - CLIP_M).tolist())
    return view.to_pixels(np.array(ahead)).T

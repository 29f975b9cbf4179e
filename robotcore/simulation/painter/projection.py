"""Project polygons of a world to the picture of a camera, and clip them at its near plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.optics import CameraView
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
        self._corners = np.concatenate((np.empty((0, 3)), *loops))
        lengths = np.array([len(loop) for loop in loops], dtype=np.intp)
        self._starts = compute_run_starts(lengths)
        self._ends = self._starts + lengths
        # A polygon that is clipped gets one more corner.
        corners = np.minimum(np.arange(lengths.max(initial=0) + 1)[:, None], lengths - 1)
        self._indices = self._starts + corners

    def project(self, view: CameraView, is_turned: NDArray[np.bool_]) -> Iterator[tuple[int, Area]]:
        """Yield the number and the pixels of each polygon, unless the whole polygon is outside the picture.

        is_turned: whether each polygon points to the camera. The others are left out.
        """
        if not (len(self._starts) and is_turned.any()):
            return
        corners = view.to_camera(self._corners)
        is_outside, is_cut = self._classify(view, corners)
        shown = np.flatnonzero(is_turned & ~is_outside)
        indices = self._indices[:, shown]
        pixels = view.to_pixels(np.maximum(corners[indices.ravel()], _NEAREST)).T.reshape(2, *indices.shape)
        for index in np.flatnonzero(is_cut[shown]).tolist():
            span = slice(self._starts[shown[index]], self._ends[shown[index]])
            pixels[:, :, index] = _clip_at_near_plane(view, corners[span], len(indices)).T
        yield from zip(shown.tolist(), rasterize(pixels, view.intrinsics.width, view.intrinsics.height), strict=True)

    def _classify(self, view: CameraView, corners: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return whether each polygon is outside the picture, and whether the near plane may cut it, each (n,).

        corners: the corners of all polygons in the camera's frame, (corners, 3).
        """
        i = view.intrinsics
        left, right = (i.cx + 0.5) / i.focal_length, (i.width - 0.5 - i.cx) / i.focal_length
        top, bottom = (i.cy + 0.5) / i.focal_length, (i.height - 0.5 - i.cy) / i.focal_length
        sides = np.array(((-1, 0, -left), (1, 0, -right), (0, -1, -top), (0, 1, -bottom), (0, 0, -1)))
        is_beyond = sides @ corners.T > _SIDE_OFFSETS
        # A polygon is outside the picture if all its corners are beyond the same side.
        is_outside = np.asarray(np.logical_and.reduceat(is_beyond, self._starts, axis=1).any(axis=0))
        return is_outside, np.logical_or.reduceat(is_beyond[4], self._starts)


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


def _clip_at_near_plane(view: CameraView, corners: Array, count: int) -> Array:
    """Clip a face at the near plane, and return the corners of the rest in pixels, (count, 2).

    corners: the face's corners in the camera's frame, (n, 3).
    count: the number of corners to return. The last one is repeated.
    """
    ahead = clip(corners.tolist(), (corners[:, 2] - CLIP_M).tolist())
    return view.to_pixels(np.array(ahead + ahead[-1:] * (count - len(ahead))))

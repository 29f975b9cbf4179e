"""The lens of a simulated camera, which moves the optical axis and distorts the pictures of a pinhole camera."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robotcore.optics import MAX_SLOPE, Array, Image, Intrinsics

Maps = tuple[NDArray[np.float32], NDArray[np.float32]]
"""The column and the row of a pixel in another picture for each pixel of a picture, each (height, width)."""

MARGIN_PX = 2
"""The number of pixels by which the picture of the pinhole camera is larger than necessary, on each side."""


class Lens:
    """Bends the pictures of a pinhole camera as the lens of a camera does.

    The pinhole camera has the focal length of the camera, and sees all that the camera sees. Each pixel gets the colour
    of the nearest pixel of the pinhole's picture, so that no colour is mixed from two bodies.

    >>> lens = Lens(Intrinsics(320, 240, 1.0, distortion=(-0.2, 0.0, 0.0, 0.0, 0.0)))
    >>> lens.pinhole.width > 320
    True
    """

    def __init__(self, intrinsics: Intrinsics) -> None:
        self.pinhole = intrinsics
        """The intrinsics of the pinhole camera."""
        self._maps: Maps | None = None
        if not intrinsics.is_pinhole:
            self.pinhole, self._maps = _build_maps(intrinsics)

    def bend(self, image: Image) -> Image:
        """Return the picture of the camera for a picture of the pinhole camera."""
        if self._maps is None:
            return image
        import cv2

        return np.asarray(cv2.remap(image, *self._maps, cv2.INTER_NEAREST), dtype=np.uint8)


def is_invertible(intrinsics: Intrinsics) -> bool:
    """Return whether each point of a picture shows exactly one direction, less than 80° off the optical axis."""
    edge = _list_edge(intrinsics)
    flat = intrinsics.undistort(edge)
    slopes = np.abs(flat - (intrinsics.cx, intrinsics.cy)) / intrinsics.focal_length
    if slopes.max() >= MAX_SLOPE:
        return False
    return bool(np.abs(intrinsics.distort(flat) - edge).max() < 0.01)


def _build_maps(intrinsics: Intrinsics) -> tuple[Intrinsics, Maps]:
    """Return the intrinsics of the pinhole camera, and the column and the row of its pixel for each pixel."""
    i = intrinsics
    reach = np.abs(i.undistort(_list_edge(i)) - (i.cx, i.cy)).max(axis=0)
    width, height = (2 * math.ceil(each + MARGIN_PX) for each in reach)
    fov = 2 * math.atan(width / 2 / i.focal_length)
    pinhole = Intrinsics(width, height, fov)
    rows, columns = np.mgrid[0 : i.height, 0 : i.width]
    flat = i.undistort(np.stack((columns.ravel(), rows.ravel()), axis=1).astype(np.float64))
    flat += (pinhole.cx - i.cx, pinhole.cy - i.cy)
    columns, rows = (flat[:, axis].reshape(i.height, i.width).astype(np.float32) for axis in (0, 1))
    return pinhole, (columns, rows)


def _list_edge(i: Intrinsics) -> Array:
    """Return points on the edge of a picture, (n, 2)."""
    u, v = np.arange(-1.0, i.width + 1), np.arange(-1.0, i.height + 1)
    sides = [(u, np.full_like(u, v[0])), (u, np.full_like(u, v[-1])), (np.full_like(v, u[0]), v)]
    sides.append((np.full_like(v, u[-1]), v))
    return np.concatenate([np.stack(side, axis=1) for side in sides])

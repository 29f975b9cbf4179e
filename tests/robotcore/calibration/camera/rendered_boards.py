"""Pictures of chessboards at random poses, by a camera with known intrinsics, distortion and noise."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.calibration.camera.board import Board
from robotcore.lens import is_invertible
from robotcore.optics import Image, Intrinsics

Array = NDArray[np.float64]

SUPERSAMPLING = 3
TEXEL_PX = 24
"""The side of a square of the board's texture, in pixels."""


@dataclass(frozen=True)
class TrueCamera:
    """A camera that renders boards."""

    width: int
    height: int
    focal_length: float
    """The focal length in pixels."""
    centre: tuple[float, float]
    """The column and the row of the optical axis, in pixels."""
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """OpenCV's k1, k2, p1, p2 and k3."""
    noise: float = 0.0
    """The standard deviation of a pixel's noise, in grey levels."""

    @property
    def intrinsics(self) -> Intrinsics:
        """The camera as the project describes it."""
        fov = 2 * math.atan(self.width / 2 / self.focal_length)
        return Intrinsics(self.width, self.height, fov, self.centre, self.distortion)

    @property
    def horizontal_fov(self) -> float:
        return self.intrinsics.horizontal_fov

    @classmethod
    def draw(cls, random_: random.Random, width: int = 640, height: int = 480) -> TrueCamera:
        """Draw a camera like those of robots: 45° to 80° wide, with a lens that bends lines visibly."""
        while True:
            focal_length = width / 2 / math.tan(math.radians(random_.uniform(45, 80)) / 2)
            shift_u, shift_v = random_.uniform(-0.03, 0.03), random_.uniform(-0.03, 0.03)
            centre = (width - 1) / 2 + shift_u * width, (height - 1) / 2 + shift_v * height
            k1, k2 = random_.uniform(-0.30, 0.10), random_.uniform(-0.05, 0.08)
            tangential = random_.uniform(-0.002, 0.002), random_.uniform(-0.002, 0.002)
            noise = random_.uniform(1.0, 6.0)
            camera = cls(width, height, focal_length, centre, (k1, k2, *tangential, 0.0), noise)
            if is_invertible(camera.intrinsics):  # others are no lenses
                return camera

    @cached_property
    def rays(self) -> NDArray[np.float32]:
        """The undistorted direction of each fine pixel, (height, width, 2)."""
        s, i = SUPERSAMPLING, self.intrinsics
        u, v = np.meshgrid(np.arange(self.width * s), np.arange(self.height * s))
        pixels = i.undistort((np.stack((u.ravel(), v.ravel()), axis=1) + 0.5) / s - 0.5)
        rays = (pixels - (i.cx, i.cy)) / i.focal_length
        return rays.astype(np.float32).reshape(self.height * s, self.width * s, 2)

    def render(self, board: Board, rotation: Array, position: Array, random_: random.Random) -> Image:
        """Return a grey picture of a board.

        rotation: turns the board's axes into the camera's, a Rodrigues vector.
        position: the position of the board's first corner in the camera's frame, in metres.
        """
        turn = np.asarray(cv2.Rodrigues(rotation)[0])
        plane = np.linalg.inv(np.column_stack((turn[:, 0], turn[:, 1], position))).astype(np.float32)
        x, y = self.rays[..., 0], self.rays[..., 1]
        a, b, c = (row[0] * x + row[1] * y + row[2] for row in plane)
        scale = np.float32(TEXEL_PX / board.square_m)
        # The texture begins two squares before the first corner: a square, and a white margin as wide.
        u = (a / c * scale + 2 * TEXEL_PX - 0.5).astype(np.float32)
        v = (b / c * scale + 2 * TEXEL_PX - 0.5).astype(np.float32)
        u[c <= 0] = -1e6
        fine = cv2.remap(_draw_texture(board), u, v, cv2.INTER_LINEAR, borderValue=110)
        size = (self.width, self.height)
        small = cv2.GaussianBlur(np.asarray(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), float), (0, 0), 0.6)
        noise = np.random.default_rng(random_.getrandbits(64)).normal(0.0, self.noise, small.shape)
        return np.asarray(np.clip(np.rint(small + noise), 0, 255), np.uint8)

    def render_views(self, board: Board, count: int, random_: random.Random) -> Iterator[Image]:
        """Yield pictures of a board that a person moves: near and far, tilted, and in all parts of the picture."""
        extent = np.array(((board.columns - 1) / 2, (board.rows - 1) / 2)) * board.square_m
        for _ in range(count):
            tilt = [random_.uniform(-0.6, 0.6), random_.uniform(-0.6, 0.6), random_.uniform(-0.3, 0.3)]
            rotation = np.array(tilt)
            width_share = random_.uniform(0.3, 0.8)  # of the picture that the board fills
            depth = 2 * extent[0] * self.focal_length / (width_share * self.width)
            reach = np.array((self.width, self.height)) * (1 - width_share) / 2
            offset = [random_.uniform(-1, 1) * reach[0], random_.uniform(-1, 1) * reach[1]]
            middle = np.array((offset[0] * depth / self.focal_length, offset[1] * depth / self.focal_length, depth))
            turn = np.asarray(cv2.Rodrigues(rotation)[0])
            yield self.render(board, rotation, middle - turn @ (*extent, 0.0), random_)


def _draw_texture(board: Board) -> Image:
    columns, rows = board.columns + 1, board.rows + 1
    cells = np.add.outer(np.arange(rows), np.arange(columns)) % 2
    squares = np.kron(np.where(cells, 235, 25), np.ones((TEXEL_PX, TEXEL_PX))).astype(np.uint8)
    return np.pad(squares, TEXEL_PX, constant_values=235)

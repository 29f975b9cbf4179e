"""Renders pictures of chessboards, as a camera with known intrinsics, lens and noise sees them."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.calibration.camera.board import Board
from robotcore.calibration.least_squares import Array
from robotcore.optics import Image, Intrinsics

SUPERSAMPLING = 3
"""The number of rendered points in a pixel, along the rows and along the columns."""

TEXEL_PX = 24
"""The side of a square of the board's texture, in pixels."""

BLACK, WHITE, BACKGROUND = 25, 235, 110
"""The grey levels of the squares, and of everything beside the board."""

BLUR_PX = 0.6
"""The standard deviation of the blur of the lens, in pixels."""


@dataclass(frozen=True)
class BoardRenderer:
    """A camera that sees a board, and nothing else."""

    intrinsics: Intrinsics
    noise_levels: float = 0.0
    """The standard deviation of a pixel's noise, in grey levels."""

    @cached_property
    def rays(self) -> NDArray[np.float32]:
        """The undistorted direction of each fine pixel, (height, width, 2)."""
        s, i = SUPERSAMPLING, self.intrinsics
        u, v = np.meshgrid(np.arange(i.width * s), np.arange(i.height * s))
        pixels = i.undistort((np.stack((u.ravel(), v.ravel()), axis=1) + 0.5) / s - 0.5)
        rays = (pixels - (i.cx, i.cy)) / i.focal_length
        return rays.astype(np.float32).reshape(i.height * s, i.width * s, 2)

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
        fine = cv2.remap(_draw_texture(board), u, v, cv2.INTER_LINEAR, borderValue=BACKGROUND)
        size = (self.intrinsics.width, self.intrinsics.height)
        small = cv2.GaussianBlur(
            np.asarray(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), float), (0, 0), BLUR_PX
        )
        noise = np.random.default_rng(random_.getrandbits(64)).normal(0.0, self.noise_levels, small.shape)
        return np.asarray(np.clip(np.rint(small + noise), 0, 255), np.uint8)

    def render_views(self, board: Board, count: int, random_: random.Random) -> Iterator[Image]:
        """Yield pictures of a board that a person moves: near and far, tilted, and in all parts of the picture."""
        extent = np.array(((board.columns - 1) / 2, (board.rows - 1) / 2)) * board.square_m
        for _ in range(count):
            tilt = [random_.uniform(-0.6, 0.6), random_.uniform(-0.6, 0.6), random_.uniform(-0.3, 0.3)]
            rotation = np.array(tilt)
            width_share = random_.uniform(0.3, 0.8)  # of the picture that the board fills
            depth = 2 * extent[0] * self.intrinsics.focal_length / (width_share * self.intrinsics.width)
            reach = np.array((self.intrinsics.width, self.intrinsics.height)) * (1 - width_share) / 2
            offset = [random_.uniform(-1, 1) * reach[0], random_.uniform(-1, 1) * reach[1]]
            middle = np.array(
                (
                    offset[0] * depth / self.intrinsics.focal_length,
                    offset[1] * depth / self.intrinsics.focal_length,
                    depth,
                )
            )
            turn = np.asarray(cv2.Rodrigues(rotation)[0])
            yield self.render(board, rotation, middle - turn @ (*extent, 0.0), random_)


def _draw_texture(board: Board) -> Image:
    columns, rows = board.columns + 1, board.rows + 1
    cells = np.add.outer(np.arange(rows), np.arange(columns)) % 2
    squares = np.kron(np.where(cells, WHITE, BLACK), np.ones((TEXEL_PX, TEXEL_PX))).astype(np.uint8)
    return np.pad(squares, TEXEL_PX, constant_values=WHITE)

"""Worlds with a picture on the floor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from robotcore.description import WorldDescription, load_world

QUADRANTS = np.zeros((20, 30, 3), np.uint8)
"""A picture in RGB: red at the upper left, green at the upper right, blue at the lower left, and white."""
QUADRANTS[:10, :15], QUADRANTS[:10, 15:], QUADRANTS[10:, :15], QUADRANTS[10:, 15:] = (
    (255, 0, 0),
    (0, 255, 0),
    (0, 0, 255),
    (255, 255, 255),
)

COURSE = """
name = "course"
[floor]
length_m = 4.0
width_m = 4.0
colour = [200, 190, 180]
image = { file = "course.png", length_m = 1.5, x_m = 0.5, y_m = -0.25 }
[light]
ambient = 1.0
diffuse = 0.0
"""
"""A world with a picture of 1.5 m x 1 m, whose middle is at (0.5, -0.25)."""


def encode_png(picture: Any) -> bytes:
    """Return a picture in RGB, in grey, or in RGB with opacity, as a PNG."""
    picture = np.asarray(picture)
    if picture.ndim > 2:
        picture = picture[:, :, [2, 1, 0, 3][: picture.shape[2]]]
    return cv2.imencode(".png", np.ascontiguousarray(picture))[1].tobytes()


def write_course(folder: Path, picture: Any = QUADRANTS, text: str = COURSE) -> str:
    """Write a world's file and its picture, and return the name of the world's file."""
    (folder / "course.png").write_bytes(picture if isinstance(picture, bytes) else encode_png(picture))
    file = folder / "course.toml"
    file.write_text(text)
    return str(file)


def load_course(folder: Path, picture: Any = QUADRANTS, text: str = COURSE) -> WorldDescription:
    """Return a world with a picture."""
    return load_world(write_course(folder, picture, text))

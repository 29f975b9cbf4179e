"""The pictures of failing runs, small enough that a page with a hundred of them still goes through the mail."""

from __future__ import annotations

from base64 import b64encode
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np

from robotcore.hal.devices import Image

MAX_WIDTH = 480
QUALITY = 80
"""Of a JPEG. A camera's noise, which makes a PNG big, is not what one looks at a failing run for."""


def embedded(file: Path) -> str:
    """Return a picture's file as a ``data:`` URI of a small JPEG; empty where there is none that can be read."""
    with suppress(OSError, cv2.error):
        image = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
        if image is not None:
            return _jpeg_uri(_narrowed(np.asarray(image, np.uint8)))
    return ""


def _jpeg_uri(image: Image) -> str:
    _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return f"data:image/jpeg;base64,{b64encode(encoded.tobytes()).decode()}"


def _narrowed(image: Image) -> Image:
    height, width = image.shape[:2]
    if width <= MAX_WIDTH:
        return image
    size = MAX_WIDTH, round(height * MAX_WIDTH / width)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)

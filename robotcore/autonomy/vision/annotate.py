"""Boxes drawn round blobs in a picture."""

from __future__ import annotations

from collections.abc import Iterable

import cv2

from robotcore.autonomy.vision.colour import Blob
from robotcore.hal.devices import Image

YELLOW = (0, 255, 255)


def draw_boxes(image: Image, blobs: Iterable[Blob]) -> Image:
    """Return a copy of a BGR picture with a yellow rectangle round each blob, clear of it by a pixel."""
    picture = image.copy()
    for blob in blobs:
        left, top, width, height = blob.box
        cv2.rectangle(picture, (left - 3, top - 3), (left + width + 2, top + height + 2), YELLOW, 2)
    return picture

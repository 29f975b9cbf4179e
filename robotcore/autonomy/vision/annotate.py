"""Draws boxes around blobs in a picture."""

from __future__ import annotations

from collections.abc import Iterable

import cv2

from robotcore.autonomy.vision.colour_detector import Blob
from robotcore.hal.devices import Image

YELLOW = (0, 255, 255)


def draw_boxes(image: Image, blobs: Iterable[Blob]) -> Image:
    """Return a copy of a BGR picture with a yellow rectangle around each blob, one pixel outside the blob's box.

    >>> import numpy as np
    >>> picture = np.zeros((48, 64, 3), np.uint8)
    >>> blob = Blob(centroid=(20.0, 15.0), box=(18, 12, 5, 7), area=35, bearing=0.1, is_clipped=False)
    >>> draw_boxes(picture, [blob])[12, 16].tolist()
    [0, 255, 255]
    """
    picture = image.copy()
    for blob in blobs:
        left, top, width, height = blob.box
        cv2.rectangle(picture, (left - 3, top - 3), (left + width + 2, top + height + 2), YELLOW, 2)
    return picture

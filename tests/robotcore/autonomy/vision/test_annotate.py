from __future__ import annotations

import numpy as np
import pytest

from robotcore.autonomy.vision import ColourDetector, draw_boxes
from robotcore.autonomy.vision.annotate import YELLOW
from tests.robotcore.autonomy.vision.pictures import INTRINSICS, bgr, draw_rectangles

BOX = (20, 15, 8, 6)
IMAGE = draw_rectangles((bgr(128), BOX))
BLOBS = ColourDetector("green").find(IMAGE, INTRINSICS)


def test_rectangle_surrounds_the_blob() -> None:
    rows, columns = np.nonzero((draw_boxes(IMAGE, BLOBS) == YELLOW).all(axis=2))
    left, top, width, height = BOX
    assert columns.min() < left - 1
    assert columns.max() > left + width
    assert rows.min() < top - 1
    assert rows.max() > top + height


def test_blob_and_a_pixel_around_it_stay_unchanged() -> None:
    left, top, width, height = BOX
    inside = slice(top - 1, top + height + 1), slice(left - 1, left + width + 1)
    assert (draw_boxes(IMAGE, BLOBS)[inside] == IMAGE[inside]).all()


def test_original_picture_does_not_change() -> None:
    before = IMAGE.copy()
    assert draw_boxes(IMAGE, BLOBS) is not IMAGE
    assert (before == IMAGE).all()


def test_without_blobs_nothing_is_drawn() -> None:
    assert (draw_boxes(IMAGE, []) == IMAGE).all()


@pytest.mark.parametrize("box", [(0, 0, 6, 6), (58, 42, 6, 6)])
def test_box_of_a_blob_at_the_edge_is_clipped(box: tuple[int, int, int, int]) -> None:
    image = draw_rectangles((bgr(128), box))
    picture = draw_boxes(image, ColourDetector("green").find(image, INTRINSICS))
    assert picture.shape == image.shape
    assert (picture == YELLOW).all(axis=2).any()

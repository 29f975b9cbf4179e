from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from robotcore.autonomy.vision.patches import Patch, measured, outlines

Rectangle = tuple[int, int, int, int]
RECTANGLE = st.tuples(st.integers(0, 30), st.integers(0, 20), st.integers(1, 12), st.integers(1, 12))
ELLIPSE = st.tuples(st.integers(2, 14), st.integers(2, 14), st.integers(0, 179))


def mask_of(*rectangles: Rectangle) -> NDArray[np.uint8]:
    mask = np.zeros((40, 50), np.uint8)
    for left, top, width, height in rectangles:
        mask[top : top + height, left : left + width] = 1
    return mask


def only(mask: NDArray[np.uint8]) -> Patch:
    (outline,) = outlines(mask)
    return measured(outline)


@given(RECTANGLE)
def test_a_rectangle_is_measured_exactly(rectangle: Rectangle) -> None:
    left, top, width, height = rectangle
    patch = only(mask_of(rectangle))
    assert (patch.box, patch.area) == (rectangle, width * height)
    assert patch.centroid == pytest.approx((left + (width - 1) / 2, top + (height - 1) / 2))


@given(st.lists(RECTANGLE, min_size=2, max_size=6))
def test_the_area_is_the_number_of_pixels_whatever_the_shape(rectangles: list[Rectangle]) -> None:
    mask = mask_of(*rectangles)
    for outline in outlines(mask):
        filled = np.zeros_like(mask)
        cv2.drawContours(filled, [outline], -1, 1, cv2.FILLED)
        assert measured(outline).area == filled.sum()


@given(ELLIPSE)
def test_the_centroid_is_that_of_the_pixels(ellipse: tuple[int, int, int]) -> None:
    across, down, turned = ellipse
    mask = np.zeros((40, 50), np.uint8)
    cv2.ellipse(mask, (20, 15), (across, down), turned, 0, 300, 1, cv2.FILLED)
    rows, columns = np.nonzero(mask)
    assert only(mask).centroid == pytest.approx((columns.mean(), rows.mean()), abs=0.2)


def test_a_hole_counts_as_filled() -> None:
    mask = mask_of((10, 10, 12, 9))
    mask[13:15, 12:20] = 0
    assert only(mask) == only(mask_of((10, 10, 12, 9)))


def test_patches_that_touch_at_a_corner_are_one() -> None:
    assert only(mask_of((5, 5, 3, 3), (8, 8, 4, 4))).area == 25


def test_outlines_are_moved_by_the_offset() -> None:
    (outline,) = outlines(mask_of((5, 6, 3, 3)), (100, 200))
    assert measured(outline).box == (105, 206, 3, 3)


def test_lies_in_a_box_up_to_its_edge() -> None:
    patch = Patch((10.0, 5.0), (8, 3, 5, 5), 25)
    assert patch.lies_in((10, 5, 1, 1))
    assert not patch.lies_in((11, 5, 4, 4))
    assert not patch.lies_in((4, 5, 6, 4))

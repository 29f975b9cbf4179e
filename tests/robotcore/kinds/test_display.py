"""A display takes pictures only."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from robotcore.errors import InvalidCommandError
from robotcore.kinds.display import MemoryDisplay
from tests.texts import Raises


@pytest.mark.parametrize("shape", [(20, 30, 3), (20, 30), (1, 1)])
def test_a_display_shows_colour_and_grey_pictures(shape: tuple[int, ...]) -> None:
    display, image = MemoryDisplay("screen"), np.full(shape, 7, np.uint8)
    display.show(image)
    assert np.array_equal(display.picture, image)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((20, 30, 3)),
        np.zeros((20, 30), bool),
        np.zeros((20, 30, 2), np.uint8),
        np.zeros((20, 30, 4), np.uint8),
        np.zeros((0, 0, 3), np.uint8),
        np.zeros((0, 30), np.uint8),
        np.zeros(5, np.uint8),
        np.zeros((), np.uint8),
        np.zeros((2, 2, 2, 2), np.uint8),
        [[1, 2], [3, 4]],
        None,
    ],
    ids=["float", "bool", "two", "four", "empty", "empty-grey", "row", "number", "four-sides", "list", "none"],
)
def test_a_display_refuses_what_is_no_picture(image: Any, raises: Raises) -> None:
    display = MemoryDisplay("screen")
    with raises(InvalidCommandError):
        display.show(image)
    assert display.picture is None


def test_a_display_copies_a_picture_that_may_change() -> None:
    display, image = MemoryDisplay("screen"), np.zeros((20, 30), np.uint8)
    display.show(image)
    image[:] = 9
    assert display.picture is not None
    assert not display.picture.any()


def test_a_display_keeps_a_picture_that_cannot_change_without_a_copy() -> None:
    display, image = MemoryDisplay("screen"), np.zeros((20, 30), np.uint8)
    image.flags.writeable = False
    display.show(image)
    assert display.picture is image


def test_a_display_copies_a_read_only_view_of_a_picture_that_may_change() -> None:
    display, image = MemoryDisplay("screen"), np.zeros((20, 30), np.uint8)
    view = image[:]
    view.flags.writeable = False
    display.show(view)
    image[:] = 9
    assert display.picture is not None
    assert not display.picture.any()

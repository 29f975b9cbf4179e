"""Tests cameras: whether they deliver pictures, and the order of their colours, columns and rows, by a red object."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotcore.hal.device_test import (
    FLIPPED_HORIZONTALLY,
    FLIPPED_VERTICALLY,
    RED_AND_BLUE_SWAPPED,
    ROTATED_180,
    DeviceTest,
)
from robotcore.hal.simulation_state import SimulationState
from robotcore.optics import CameraView, Image

MIN_CONTRAST_LEVELS = 2.0
"""A picture whose grey levels have a smaller standard deviation shows nothing."""

NEW_PICTURE_S = 2.0
"""The longest wait for a new picture, in seconds."""

MIN_LEAD = 40
"""A pixel is red, or blue, if this colour leads the two others by this many grey levels."""

MIN_SHARE = 0.003
"""The object must have at least this share of the picture's pixels."""

PATCH_PX = 2
"""The distance from the middle to the edge of the part of a simulated picture that is compared, in pixels."""

Mask = NDArray[np.bool_]
Place = tuple[float, float]


def test_cameras(test: DeviceTest, cameras: Sequence[Any]) -> None:
    """Take pictures of each camera, and compare the place and the colour of a red object."""
    for camera in cameras:
        if _deliver_pictures(test, camera.name):
            found = _find_true_ball(test, camera.name) if test.state else _find_held_object(test, camera.name)
            if found:
                _report(test, camera.name, *found)


def _deliver_pictures(test: DeviceTest, name: str) -> bool:
    device: Any = test.robot[name]
    first = device.read()
    if not test.wait_until(lambda: device.read().sequence != first.sequence, NEW_PICTURE_S):
        text = f"delivers no new picture within {NEW_PICTURE_S:g} s"
        test.fail(name, text, "Check its cable, and unplug it for a moment", "camera-frozen")
        return False
    image = device.read().image
    if float(image.std()) < MIN_CONTRAST_LEVELS:
        text = f"shows nothing but the grey level {image.mean():.0f} of 255"
        test.fail(name, text, "Remove its cover, and give it light", "camera-dark")
        return False
    return True


def _find_true_ball(test: DeviceTest, name: str) -> tuple[bool, bool, bool] | None:
    """Return whether columns, rows and colours are swapped, from a red ball that the simulated camera sees."""
    state = test.state
    assert state
    image = _read_image(test, name)
    found = [
        (is_mirrored, is_upside_down, is_swapped)
        for is_mirrored, is_upside_down, is_swapped in product((False, True), repeat=3)
        for place in _list_red_balls(state, name)
        if _is_coloured(image, _transform(place, image, is_mirrored, is_upside_down), is_swapped)
    ]
    if len(found) != 1:
        reason = "sees no red ball" if not found else "has the red ball too near the middle of its picture"
        text = f"the simulated camera {reason}, so the order of rows, columns and colours is unknown"
        test.skip(name, f"{text}. Use --world bench")
        return None
    return found[0]


def _list_red_balls(state: SimulationState, name: str) -> list[Place]:
    """Return the column and the row of the middle of each red ball that a simulated camera sees."""
    camera = next((each for each in state.robot.all_of("camera") if each.name == name), None)
    if camera is None:
        return []
    view = CameraView.of(camera.intrinsics, state.joints.locate(camera.mount), state.pose())
    balls = [ball for ball in state.world.targets if ball.colour[0] > max(ball.colour[1:]) + MIN_LEAD]
    points = [np.array([[ball.x_m, ball.y_m, ball.radius_m]]) for ball in balls]
    seen = [point for point in points if view.shows(point)[0]]
    return [tuple(view.to_pixels(view.to_camera(point))[0].tolist()) for point in seen]


def _transform(place: Place, image: Image, is_mirrored: bool, is_upside_down: bool) -> Place:  # noqa: FBT001
    (u, v), (height, width) = place, image.shape[:2]
    return width - 1 - u if is_mirrored else u, height - 1 - v if is_upside_down else v


def _is_coloured(image: Image, place: Place, is_swapped: bool) -> bool:  # noqa: FBT001
    """Return whether the picture is red at a place; blue if ``is_swapped``."""
    column, row = round(place[0]), round(place[1])
    rows = slice(max(row - PATCH_PX, 0), row + PATCH_PX + 1)
    patch = image[rows, max(column - PATCH_PX, 0) : column + PATCH_PX + 1]
    return bool(patch.size and _find_colour(patch, is_swapped).mean() > 0.5)


def _find_held_object(test: DeviceTest, name: str) -> tuple[bool, bool, bool] | None:
    """Return whether columns, rows and colours are swapped, from a red object that the person holds."""
    text = f"Keep everything red and blue out of the view of {name}"
    if not test.instruct(name, "clear", text):
        test.skip(name, "no person holds a red object before it, so the order of its colours is unknown")
        return None
    before = [_find_colour(_read_image(test, name), is_swapped) for is_swapped in (False, True)]
    text = f"Hold something red before {name}: on the robot's left, and higher than the middle of its view"
    if not test.instruct(name, "red", text):
        test.skip(name, "no person holds a red object before it, so the order of its colours is unknown")
        return None
    image = _read_image(test, name)
    new = [_find_colour(image, is_swapped) & ~before[is_swapped] for is_swapped in (False, True)]
    is_swapped = bool(new[1].sum() > new[0].sum())
    mask = new[is_swapped]
    if mask.mean() < MIN_SHARE:
        text = "shows nothing red where a red object should be"
        test.warn(name, text, "Repeat the test with a larger object and more light", "camera-unclear")
        return None
    rows, columns = np.nonzero(mask)
    return bool(columns.mean() > image.shape[1] / 2), bool(rows.mean() > image.shape[0] / 2), is_swapped


def _read_image(test: DeviceTest, name: str) -> Image:
    device: Any = test.robot[name]
    image: Image = device.read().image
    return image


def _find_colour(image: Image, is_swapped: bool) -> Mask:  # noqa: FBT001
    """Return which pixels are red, or blue if ``is_swapped``, (height, width)."""
    parts = image.astype(np.int16)
    main, other = (parts[..., 0], parts[..., 2]) if is_swapped else (parts[..., 2], parts[..., 0])
    return np.asarray(main > np.maximum(parts[..., 1], other) + MIN_LEAD)


def _report(test: DeviceTest, name: str, is_mirrored: bool, is_upside_down: bool, is_swapped: bool) -> None:  # noqa: FBT001
    remedy = "Turn the camera, or correct its driver's settings"
    if is_mirrored and is_upside_down:
        test.correct(name, "its pictures are upside down", ROTATED_180, remedy=remedy, kind="camera-rotated")
    elif is_mirrored:
        test.correct(name, "its pictures are mirrored", FLIPPED_HORIZONTALLY, remedy=remedy, kind="camera-mirrored")
    elif is_upside_down:
        text = "its pictures are upside down and mirrored"
        test.correct(name, text, FLIPPED_VERTICALLY, remedy=remedy, kind="camera-upside-down")
    if is_swapped:
        text, remedy = "red is blue in its pictures", "Correct the format of the pictures in its driver"
        test.correct(name, text, RED_AND_BLUE_SWAPPED, remedy=remedy, kind="camera-colours")
    if not (is_mirrored or is_upside_down or is_swapped):
        test.confirm(name, "its pictures have the right colours, and left is left")

"""What every frame is, whatever the camera gave."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from drivers.raspberrypi.cameras.framing import Framing
from drivers.raspberrypi.cameras.settings import CameraSettings
from drivers.raspberrypi.cameras.source import Shot
from robotcore.errors import DeviceError
from robotcore.hal.devices import Frame, Image
from tests.drivers.raspberrypi.cameras.bench import EYE, plain

CORNERS: Image = plain(0)
CORNERS[0, 0], CORNERS[0, -1], CORNERS[-1, 0], CORNERS[-1, -1] = 1, 2, 3, 4


def frame_of(image: Image, **settings: Any) -> Frame:
    return Framing(EYE, CameraSettings(**settings)).frame(Shot(image, 0.5))


def corners_of(image: Image) -> list[int]:
    return [int(image[row, column, 0]) for row in (0, -1) for column in (0, -1)]


@pytest.mark.parametrize(
    "settings, corners",
    [
        ({}, [1, 2, 3, 4]),
        ({"rotate_180": True}, [4, 3, 2, 1]),
        ({"flip_horizontal": True}, [2, 1, 4, 3]),
        ({"flip_vertical": True}, [3, 4, 1, 2]),
        ({"rotate_180": True, "flip_horizontal": True}, [3, 4, 1, 2]),
        ({"rotate_180": True, "flip_horizontal": True, "flip_vertical": True}, [1, 2, 3, 4]),
    ],
)
def test_a_camera_that_is_mounted_otherwise_gives_an_upright_picture(settings: Any, corners: list[int]) -> None:
    assert corners_of(frame_of(CORNERS, **settings).image) == corners


def test_the_picture_is_contiguous_and_nobody_can_write_to_it() -> None:
    image = frame_of(np.repeat(plain(), 2, axis=1)[:, ::2]).image
    assert image.flags.c_contiguous
    assert not image.flags.writeable


def test_frames_keep_the_time_of_the_shot_and_are_numbered() -> None:
    framing = Framing(EYE, CameraSettings())
    frames = [framing.frame(Shot(plain(), time)) for time in (0.1, 0.3)]
    assert [(frame.time, frame.sequence) for frame in frames] == [(0.1, 0), (0.3, 1)]


def test_another_size_of_the_same_shape_is_averaged_down() -> None:
    large = plain(0, width=64, height=48)
    large[::2] = 200
    image = frame_of(large).image
    assert image.shape == (24, 32, 3)
    assert set(image.flat) == {100}


@pytest.mark.parametrize("width, height", [(48, 24), (24, 32), (32, 30)])
def test_another_shape_is_refused_for_its_field_of_view(width: int, height: int) -> None:
    with pytest.raises(DeviceError, match=rf"eye: it gives {width}x{height} px, the robot's description says 32x24"):
        frame_of(plain(width=width, height=height))


def test_a_shape_that_differs_by_the_rounding_of_a_pixel_only_is_no_other() -> None:
    told = EYE.model_copy(update={"width_px": 854, "height_px": 480})
    image = Framing(told, CameraSettings()).frame(Shot(plain(width=1920, height=1080), 0.0)).image
    assert image.shape == (480, 854, 3)

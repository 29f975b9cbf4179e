"""The driver of USB cameras on vivid, the kernel's simulated camera: colour bars, time stamps, unplugging."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.raspberrypi.cameras.v4l2 import UsbCamera
from robotcore.description import load_robot
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceContext
from robotcore.kinds.camera import Camera, CameraDescription
from tests.system.guest.bench import wait_until

VIVID = Path("/sys/bus/platform/drivers/vivid")
RATE_HZ = 25.0
BARS = {
    "white": "bgr",
    "yellow": "gr",
    "cyan": "bg",
    "green": "g",
    "magenta": "br",
    "red": "r",
    "blue": "b",
    "black": "",
}
"""The bars from left to right, each with its colours."""

ROBOT = load_robot("rover")
FOUND = ROBOT.first_of(CameraDescription)
assert FOUND
EYE = FOUND.model_copy(update={"width_px": 320, "height_px": 180})

Open = Callable[..., Camera]


@pytest.fixture
def clock() -> MonotonicClock:
    return MonotonicClock()


@pytest.fixture
def open_eye(clock: MonotonicClock) -> Iterator[Open]:
    opened: list[Camera] = []

    def open_it(description: CameraDescription = EYE, **settings: Any) -> Camera:
        settings = {"fps": RATE_HZ, **settings}
        opened.append(UsbCamera(**settings).open(description, DeviceContext(ROBOT, clock)))
        return opened[-1]

    yield open_it
    for camera in opened:
        camera.close()


@pytest.fixture
def unplugged() -> Iterator[Callable[[], None]]:
    """Yield a function that unplugs the camera; after the check the camera is plugged in again."""
    yield lambda: _plug("unbind")
    if not (VIVID / "vivid.0").exists():
        _plug("bind")


def failure_of(camera: Camera) -> type[DeviceError] | None:
    """Return the class of the error that reading raises; None if reading works."""
    try:
        camera.read()
    except DeviceError as error:
        return type(error)
    return None


def test_the_bars_have_their_colours(open_eye: Open) -> None:
    row = open_eye().read().image[-10]
    middles = (np.arange(len(BARS)) + 0.5) * len(row) / len(BARS)
    lit = [{colour for colour, level in zip("bgr", row[int(middle)], strict=True) if level > 90} for middle in middles]
    assert dict(zip(BARS, lit, strict=True)) == {name: set(colours) for name, colours in BARS.items()}


def test_pictures_are_numbered_and_stamped_in_order_and_never_in_the_future(
    open_eye: Open, clock: MonotonicClock
) -> None:
    camera = open_eye()
    frames = [camera.read()]
    while len(frames) < 25:
        clock.sleep_until(clock.now() + 0.01)
        frame = camera.read()
        assert frame.time <= clock.now()
        if frame.sequence != frames[-1].sequence:
            frames.append(frame)
    assert all(later.time > earlier.time for earlier, later in itertools.pairwise(frames))
    spacing = np.diff([frame.time for frame in frames]) / np.diff([frame.sequence for frame in frames])
    assert np.median(spacing) == pytest.approx(1 / RATE_HZ, rel=0.1)


def test_the_kernels_stamps_are_used(open_eye: Open) -> None:
    camera: Any = open_eye()
    assert camera._source._stamps._is_trusted


def test_another_size_of_the_same_aspect_ratio_is_scaled(open_eye: Open) -> None:
    description = EYE.model_copy(update={"width_px": 160, "height_px": 90})
    assert open_eye(description).read().image.shape == (90, 160, 3)


def test_another_aspect_ratio_is_refused(open_eye: Open) -> None:
    description = EYE.model_copy(update={"width_px": 320, "height_px": 240})
    with pytest.raises(DeviceError) as raised:
        open_eye(description)
    assert raised.value.kind == "camera-shape"


def test_an_exposure_that_it_cannot_hold_is_logged(open_eye: Open, caplog: pytest.LogCaptureFixture) -> None:
    assert open_eye().read()
    assert len(caplog.records) == 1


def test_a_missing_camera_is_an_error(open_eye: Open) -> None:
    with pytest.raises(DeviceError) as raised:
        open_eye(device=63)
    assert raised.value.device == "eye"


def test_an_unplugged_camera_is_lost_and_works_again_when_it_is_plugged_in(
    open_eye: Open, unplugged: Callable[[], None]
) -> None:
    camera = open_eye()
    last = camera.read().sequence
    unplugged()
    assert wait_until(lambda: failure_of(camera), DeviceLostError) is DeviceLostError
    _plug("bind")
    assert wait_until(lambda: failure_of(camera), None) is None
    assert camera.read().sequence > last


def test_a_camera_that_is_closed_can_be_opened_again(open_eye: Open) -> None:
    open_eye().close()
    assert open_eye().read()


def _plug(way: str) -> None:
    VIVID.joinpath(way).write_text("vivid.0")

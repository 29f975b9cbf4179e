"""The driver of USB cameras on vivid, the kernel's own camera: its colour bars, its stamps, and its going away."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.raspberrypi.cameras.source import UsbCameraSettings
from drivers.raspberrypi.cameras.v4l2 import UsbCamera
from robotcore.description import CameraDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.devices import Camera
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import Host
from tests.system.guest.bench import settled

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
"""From left to right, and of what they are made."""

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
        opened.append(UsbCamera().open(description, UsbCameraSettings(**settings), Host(ROBOT, clock)))
        return opened[-1]

    yield open_it
    for camera in opened:
        camera.close()


@pytest.fixture
def unplugged() -> Iterator[Callable[[], None]]:
    """Give what pulls the camera's plug; it is in again after the check, whatever comes of it."""
    yield lambda: _plug("unbind")
    if not (VIVID / "vivid.0").exists():
        _plug("bind")


def failure_of(camera: Camera) -> str:
    """Return why it cannot be read; empty where it can."""
    try:
        camera.read()
    except DeviceError as error:
        return str(error)
    return ""


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


def test_the_kernels_stamps_are_believed(open_eye: Open) -> None:
    camera: Any = open_eye()
    assert camera._source._stamps._is_trusted


def test_another_size_of_the_same_shape_is_made_the_described_one(open_eye: Open) -> None:
    description = EYE.model_copy(update={"width_px": 160, "height_px": 90})
    assert open_eye(description).read().image.shape == (90, 160, 3)


def test_another_shape_is_refused(open_eye: Open) -> None:
    description = EYE.model_copy(update={"width_px": 320, "height_px": 240})
    with pytest.raises(DeviceError, match="eye: it gives 320x180 px, the robot's description says 320x240"):
        open_eye(description)


def test_an_exposure_that_it_does_not_let_itself_hold_is_said(open_eye: Open, caplog: pytest.LogCaptureFixture) -> None:
    assert open_eye().read()
    assert "eye: does not let its exposure and white balance be held" in caplog.text


def test_a_camera_that_is_not_there_is_named(open_eye: Open) -> None:
    with pytest.raises(DeviceError, match="eye: there is no /dev/video63"):
        open_eye(device=63)


def test_unplugged_it_is_named_and_plugged_in_again_it_works_again(
    open_eye: Open, unplugged: Callable[[], None]
) -> None:
    camera = open_eye()
    last = camera.read().sequence
    unplugged()
    gone = "eye: /dev/video0 is gone; plug it in again"
    assert settled(lambda: failure_of(camera), gone) == gone
    _plug("bind")
    assert settled(lambda: failure_of(camera), "") == ""
    assert camera.read().sequence > last


def test_a_camera_that_is_closed_can_be_opened_again(open_eye: Open) -> None:
    open_eye().close()
    assert open_eye().read()


def _plug(way: str) -> None:
    VIVID.joinpath(way).write_text("vivid.0")

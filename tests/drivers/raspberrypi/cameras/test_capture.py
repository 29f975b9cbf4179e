"""Capture in the background: the newest picture, failures, cameras that come back, and the lock of the exposure."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from drivers.raspberrypi.cameras.capture import (
    FRAMES_IN_FLIGHT,
    LONGEST_RETRY_S,
    STEADY_SHOTS,
    CameraDriver,
    FrameConverter,
    Shot,
)
from robotcore.errors import DeviceClosedError, DeviceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from tests.drivers.raspberrypi.cameras.fakes import EYE, FakeSource, LabClock, build_lost_error, open_camera, plain
from tests.texts import CheckText, Raises

AT_LEAST_S = 30.0
"""The time limit of each wait."""


@pytest.fixture
def clock() -> LabClock:
    return LabClock()


@pytest.fixture
def source(clock: LabClock) -> FakeSource:
    return FakeSource(clock)


@pytest.fixture
def real_clock() -> Iterator[MonotonicClock]:
    clock = MonotonicClock()
    yield clock
    clock.close()


def test_read_returns_the_newest_picture(clock: LabClock, source: FakeSource) -> None:
    camera = open_camera(source)
    clock.pass_time(0.5)
    taken, frame = source.shots, camera.read()
    assert source.shots == taken
    assert frame.time == pytest.approx(clock.now(), abs=1 / 60)
    assert frame.sequence == pytest.approx(0.5 * 30 * 2, abs=1)  # polled twice as often as the camera gives pictures


def test_a_reopened_camera_locks_its_exposure_again_and_continues_to_count(
    clock: LabClock, source: FakeSource, raises: Raises
) -> None:
    camera = open_camera(source)
    last = camera.read().sequence
    source.failing = build_lost_error()
    clock.pass_time(0.1)
    with raises(DeviceError):
        camera.read()
    source.failing, source.levels = None, [40, 60, 80, 120]
    clock.pass_time(1.0)
    frame = camera.read()
    assert frame.image[0, 0, 0] == 120
    assert frame.sequence > last
    assert source.diary == ["open", "lock 100", "close", "open", "lock 120"]


def test_a_failed_camera_is_opened_again_after_longer_and_longer_times(clock: LabClock, source: FakeSource) -> None:
    camera = open_camera(source)
    source.failing = build_lost_error()
    clock.pass_time(0.1)
    tried: list[float] = []
    for _ in range(240):
        before = source.diary.count("open")
        clock.pass_time(0.1)
        if source.diary.count("open") > before:
            tried.append(clock.now())
    pauses = [round(later - earlier, 1) for earlier, later in itertools.pairwise(tried)]
    assert pauses[:2] == pytest.approx([1.0, 2.0], abs=0.2)
    assert set(pauses[2:]) <= {LONGEST_RETRY_S, LONGEST_RETRY_S + 0.1}
    source.failing = None
    clock.pass_time(5.0)
    assert camera.read()


@pytest.mark.parametrize("failure", [build_lost_error(), RuntimeError("no memory"), KeyboardInterrupt()])
def test_a_camera_that_cannot_be_opened_is_closed_again(
    clock: LabClock, source: FakeSource, failure: BaseException
) -> None:
    def fail() -> None:
        raise failure

    source.on_shot = fail
    with pytest.raises(KeyboardInterrupt if isinstance(failure, KeyboardInterrupt) else DeviceError):
        open_camera(source)
    assert source.diary == ["open", "close"]
    clock.pass_time(1.0)
    assert source.diary == ["open", "close"]


def test_a_closed_camera_takes_no_more_pictures(clock: LabClock, source: FakeSource) -> None:
    camera = open_camera(source)
    camera.close()
    camera.close()
    taken = source.shots
    clock.pass_time(1.0)
    assert source.shots == taken
    assert source.diary[-2:] == ["lock 100", "close"]
    with pytest.raises(DeviceClosedError):
        camera.read()


@pytest.fixture
def _shorten_time_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.raspberrypi.cameras.capture.CLOSING_S", 0.1)
    monkeypatch.setattr("robotcore.hal.wall_clock.STOPPING_S", 0.1)


@pytest.mark.usefixtures("_shorten_time_limits")
class TestInRealTime:
    def test_a_capture_that_hangs_keeps_neither_read_nor_close_and_is_closed_later(
        self, real_clock: MonotonicClock
    ) -> None:
        source, hangs, release, closed = FakeSource(real_clock), threading.Event(), threading.Event(), threading.Event()
        source.close = closed.set  # type: ignore[method-assign]
        camera = open_camera(source, fps=240)
        source.on_shot = lambda: hangs.set() or release.wait(AT_LEAST_S)  # type: ignore[func-returns-value]
        assert hangs.wait(AT_LEAST_S)
        last = camera.read()
        assert camera.read() is last
        camera.close()
        assert not closed.is_set()
        release.set()
        assert closed.wait(AT_LEAST_S)

    def test_a_close_that_hangs_is_not_waited_for(
        self, real_clock: MonotonicClock, caplog: pytest.LogCaptureFixture, check_text: CheckText
    ) -> None:
        source, release = FakeSource(real_clock), threading.Event()
        source.close = lambda: release.wait(AT_LEAST_S)  # type: ignore[method-assign,assignment]
        camera = open_camera(source)
        camera.close()
        release.set()
        check_text("\n".join(caplog.messages))


def convert_frame(image: Image, **settings: Any) -> Frame:
    return FrameConverter(EYE, CameraDriver(**settings)).convert(Shot(image, 0.5))


@pytest.mark.parametrize(
    "settings, corners",
    [
        ({}, [1, 2, 3, 4]),
        ({"rotate_180": True}, [4, 3, 2, 1]),
        ({"flip_horizontal": True}, [2, 1, 4, 3]),
        ({"flip_vertical": True}, [3, 4, 1, 2]),
        ({"rotate_180": True, "flip_horizontal": True, "flip_vertical": True}, [1, 2, 3, 4]),
    ],
)
def test_pictures_are_turned_upright_by_the_settings(settings: Any, corners: list[int]) -> None:
    image = plain(0)
    image[0, 0], image[0, -1], image[-1, 0], image[-1, -1] = 1, 2, 3, 4
    turned = convert_frame(image, **settings).image
    assert [turned[row, column, 0] for row in (0, -1) for column in (0, -1)] == corners


def test_another_size_of_the_same_shape_is_averaged_down() -> None:
    large = plain(0, width=64, height=48)
    large[::2] = 200
    image = convert_frame(large).image
    assert image.shape == (24, 32, 3)
    assert set(image.flat) == {100}
    assert not image.flags.writeable


@pytest.mark.parametrize("width, height", [(48, 24), (32, 30)])
def test_another_aspect_ratio_is_refused(width: int, height: int, raises: Raises) -> None:
    with raises(DeviceError, "camera-shape"):
        convert_frame(plain(width=width, height=height))


RISING = [*range(40, 140, 5), 140]


def test_exposure_is_locked_after_it_has_settled(clock: LabClock) -> None:
    source = FakeSource(clock, RISING)
    assert open_camera(source).read().image[0, 0, 0] == 140
    assert source.diary == ["open", "lock 140"]


def test_exposure_that_never_settles_is_locked_after_the_time_limit(clock: LabClock) -> None:
    source = FakeSource(clock, [50, 200] * 500)
    open_camera(source, settle_s=2.0, fps=30)
    assert source.shots == 1 + 60 + 8
    assert source.diary[-1].startswith("lock")


def test_pictures_from_before_the_lock_are_skipped(clock: LabClock) -> None:
    source = FakeSource(clock, [100] * STEADY_SHOTS + [90] * (FRAMES_IN_FLIGHT - 1) + [101])
    assert open_camera(source).read().image[0, 0, 0] == 101


def test_without_the_setting_lock_the_exposure_is_not_locked(clock: LabClock) -> None:
    source = FakeSource(clock, RISING)
    assert open_camera(source, lock=False).read().image[0, 0, 0] == 40
    assert source.diary == ["open"]


def test_a_refused_setting_is_logged_once(
    clock: LabClock, caplog: pytest.LogCaptureFixture, check_text: CheckText
) -> None:
    source = FakeSource(clock)
    source.refused, source.untaken = ["exposure", "white balance"], ["gain"]
    camera = open_camera(source)
    source.failing = OSError("gone")
    clock.pass_time(0.1)
    source.failing = None
    clock.pass_time(1.0)
    assert camera.read().sequence > 1
    check_text("\n".join(caplog.messages))


@pytest.mark.parametrize("after, is_logged", [(100, False), (110, False), (30, True), (250, True)])
def test_a_jump_of_brightness_at_the_lock_is_logged(
    after: int, is_logged: bool, clock: LabClock, caplog: pytest.LogCaptureFixture
) -> None:
    open_camera(FakeSource(clock, [100] * 10 + [after]))
    assert (len(caplog.records) == 1) == is_logged

"""Exposure and white balance settle, and are then locked."""

from __future__ import annotations

import pytest

from tests.drivers.raspberrypi.cameras.fakes import FakeSource, LabClock, open_camera
from tests.texts import CheckText

RISING = [*range(40, 140, 5), 140]


@pytest.fixture
def clock() -> LabClock:
    return LabClock()


def test_exposure_is_locked_after_it_has_settled(clock: LabClock) -> None:
    source = FakeSource(clock, RISING)
    assert open_camera(source, clock).read().image[0, 0, 0] == 140
    assert source.diary == ["open", "lock 140"]


def test_the_camera_s_report_is_waited_for(clock: LabClock) -> None:
    source = FakeSource(clock)
    source.is_settled = False
    found_at = 25

    def check_settled() -> None:
        source.is_settled = source.shots >= found_at

    source.on_shot = check_settled
    locked_after: list[int] = []
    lock = source.lock_exposure
    source.lock_exposure = lambda shot: locked_after.append(source.shots) or lock(shot)  # type: ignore[func-returns-value,method-assign]
    open_camera(source, clock)
    assert locked_after == [found_at + 1]


def test_exposure_that_never_settles_is_locked_after_the_time_limit(clock: LabClock) -> None:
    source = FakeSource(clock, [50, 200] * 500)
    open_camera(source, clock, settle_s=2.0, fps=30)
    assert source.shots == 1 + 60 + 8
    assert source.diary[-1].startswith("lock")


def test_a_slow_camera_is_given_no_more_time(clock: LabClock) -> None:
    source = FakeSource(clock, [50, 200] * 500)
    source.on_shot = lambda: clock.pass_time(0.25)
    open_camera(source, clock, settle_s=2.0, fps=30)
    assert source.shots == 9 + 8


def test_pictures_from_before_the_lock_are_skipped(clock: LabClock) -> None:
    source = FakeSource(clock)
    lock = source.lock_exposure

    def lock_with_old_pictures(shot: object) -> list[str]:
        source.levels = [90] * 7 + [101]
        return lock(shot)  # type: ignore[arg-type]

    source.lock_exposure = lock_with_old_pictures  # type: ignore[method-assign]
    assert open_camera(source, clock).read().image[0, 0, 0] == 101


def test_without_the_setting_lock_the_exposure_is_not_locked(clock: LabClock) -> None:
    source = FakeSource(clock, RISING)
    assert open_camera(source, clock, lock=False).read().image[0, 0, 0] == 40
    assert source.diary == ["open"]


def test_a_refused_setting_is_logged_once(
    clock: LabClock, caplog: pytest.LogCaptureFixture, check_text: CheckText
) -> None:
    source = FakeSource(clock)
    source.refused, source.untaken = ["exposure", "white balance"], ["gain"]
    camera = open_camera(source, clock)
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
    open_camera(FakeSource(clock, [100] * 10 + [after]), clock)
    assert (len(caplog.records) == 1) == is_logged

"""Cameras on the Pi's connector, with a double of picamera2."""

from __future__ import annotations

import sys
from typing import Any
from unittest.mock import Mock

import pytest

from drivers.raspberrypi.cameras.capture import CapturingCamera
from drivers.raspberrypi.cameras.csi import PiCamera
from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.hardware import DeviceContext
from robotcore.kinds.camera import CameraDescription
from tests.drivers.raspberrypi.cameras.fakepicamera import FOUND_GAIN, FOUND_GAINS, FOUND_US, FakeCamera
from tests.drivers.raspberrypi.cameras.fakes import EYE, RED_BGR, LabClock
from tests.texts import CheckText, Raises

ROVER = load_robot("rover")


@pytest.fixture
def clock() -> LabClock:
    return LabClock()


@pytest.fixture
def camera(clock: LabClock, monkeypatch: pytest.MonkeyPatch) -> FakeCamera:
    camera = FakeCamera(clock)
    monkeypatch.setitem(sys.modules, "picamera2", camera.module())
    return camera


def open_camera(clock: LabClock, description: CameraDescription = EYE, **settings: Any) -> CapturingCamera:
    return PiCamera(**settings).open(description, DeviceContext(ROVER, clock))


def test_an_odd_size_is_scaled_from_the_nearest_stream(clock: LabClock, camera: FakeCamera) -> None:
    description = EYE.model_copy(update={"width_px": 33, "height_px": 25})
    assert open_camera(clock, description).read().image.shape == (25, 33, 3)


def test_a_frames_time_is_the_sensors(clock: LabClock, camera: FakeCamera) -> None:
    clock.pass_time(1.0)
    eye = open_camera(clock)
    clock.pass_time(1.0)
    frame = eye.read()
    assert clock.now() - 1 / 60 - camera.latency_s <= frame.time <= clock.now() - camera.latency_s + 1e-6


def test_exposure_is_locked_if_the_light_changes(clock: LabClock, camera: FakeCamera) -> None:
    eye = open_camera(clock)
    found = {"ExposureTime": FOUND_US, "AnalogueGain": FOUND_GAIN, "ColourGains": FOUND_GAINS}
    assert camera.last.set.items() >= {"AeEnable": False, "AwbEnable": False, **found}.items()
    camera.lamp = 0.5
    clock.pass_time(0.1)
    assert tuple(eye.read().image[0, 0]) == tuple(level // 2 for level in RED_BGR)


def test_fixed_settings_hold_from_the_first_picture(clock: LabClock, camera: FakeCamera) -> None:
    open_camera(clock, exposure_s=0.05, gain=4.0, colour_gains=(2.1, 1.2), fps=40, lock=False)
    assert camera.last.set == {
        "FrameDurationLimits": (25_000, 50_000),
        "ExposureTime": 50_000,
        "AnalogueGain": 4.0,
        "ColourGains": (2.1, 1.2),
    }


def test_a_camera_without_colours_opens_and_its_refused_settings_are_logged(
    clock: LabClock, camera: FakeCamera, caplog: pytest.LogCaptureFixture, check_text: CheckText
) -> None:
    camera.controls = tuple(name for name in camera.controls if name not in {"AwbEnable", "ColourGains"})
    open_camera(clock, colour_gains=(2.0, 1.0))
    check_text("\n".join(caplog.messages))
    assert "AeEnable" in camera.last.set


@pytest.mark.parametrize("fps, depth", [(30, 10), (60, 8), (200, 8)])
def test_modes_are_chosen_by_field_of_view_then_rate_then_depth(
    fps: float, depth: int, clock: LabClock, camera: FakeCamera
) -> None:
    open_camera(clock, fps=fps)
    assert camera.last.config["sensor"] == {"output_size": (1640, 1232), "bit_depth": depth}


def test_libcamera_chooses_the_mode_of_a_sensor_without_modes(clock: LabClock, camera: FakeCamera) -> None:
    camera.modes = [{"format": "MJPEG"}]
    open_camera(clock)
    assert camera.last.config["sensor"] == {}


def test_a_capture_that_hangs_is_reported_flushed_and_repeated(
    clock: LabClock, camera: FakeCamera, raises: Raises
) -> None:
    eye = open_camera(clock)
    hung = camera.last
    camera.is_hanging = True
    clock.pass_time(0.1)
    with raises(DeviceError, "camera-silent"):
        eye.read()
    assert hung.flushes == 1
    assert hung.is_closed
    camera.is_hanging = False
    clock.pass_time(1.0)
    assert eye.read().sequence > camera.last.config["buffer_count"]
    assert camera.last is not hung
    assert camera.last.outstanding == 0


@pytest.mark.parametrize("models", [[], ["imx219"]])
def test_a_missing_camera_is_reported_with_the_present_ones(
    models: list[str], clock: LabClock, camera: FakeCamera, raises: Raises
) -> None:
    camera.models = models
    with raises(DeviceError, "camera-missing"):
        open_camera(clock, camera=1)


def test_a_camera_that_another_program_uses_is_reported(clock: LabClock, camera: FakeCamera, raises: Raises) -> None:
    camera.is_busy = True
    with raises(DeviceError, "camera-not-opened"):
        open_camera(clock)


@pytest.mark.parametrize(
    "failure, kind",
    [
        (ImportError("No module named 'picamera2'"), "picamera2-missing"),
        (ValueError("numpy.dtype size changed"), "picamera2-other-numpy"),
    ],
)
def test_a_library_that_cannot_be_imported_is_reported_with_the_remedy(
    failure: Exception, kind: str, clock: LabClock, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    finder = Mock(**{"find_spec.side_effect": failure})
    monkeypatch.delitem(sys.modules, "picamera2", raising=False)
    monkeypatch.setattr(sys, "meta_path", [finder])
    with raises(DeviceError, kind):
        open_camera(clock)

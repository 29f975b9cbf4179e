"""Cameras on USB, with a double of OpenCV's capture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import pytest

from drivers.raspberrypi.cameras.capture import CapturingCamera
from drivers.raspberrypi.cameras.v4l2 import UsbCamera
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceLostError
from robotcore.hardware import Connection, DeviceContext, bind_devices
from tests.drivers.raspberrypi.cameras.fakes import (
    APERTURE_PRIORITY,
    EYE,
    FOUND_KELVIN,
    FOUND_UNITS,
    MANUAL,
    RED_BGR,
    FakeWebcam,
    LabClock,
)
from tests.texts import CheckText, Raises

ROVER = load_robot("rover")


@pytest.fixture
def clock() -> LabClock:
    return LabClock()


@pytest.fixture
def webcam(clock: LabClock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeWebcam:
    webcam = FakeWebcam(clock, tmp_path / "video0")
    monkeypatch.setattr(cv2, "VideoCapture", webcam.capture)
    monkeypatch.setattr(cv2.videoio_registry, "getCameraBackends", lambda: [cv2.CAP_V4L2])
    return webcam


def open_camera(webcam: FakeWebcam, **settings: Any) -> CapturingCamera:
    driver = UsbCamera.model_construct(**{"device": str(webcam.path), **settings})
    return driver.open(EYE, DeviceContext(ROVER, webcam.clock))


def test_the_described_format_and_a_short_queue_are_requested(webcam: FakeWebcam) -> None:
    open_camera(webcam, fps=25.0, pixel_format="MJPG")
    assert webcam.captures[-1].asked == {
        cv2.CAP_PROP_FOURCC: cv2.VideoWriter.fourcc(*"MJPG"),
        cv2.CAP_PROP_FRAME_WIDTH: 32,
        cv2.CAP_PROP_FRAME_HEIGHT: 24,
        cv2.CAP_PROP_FPS: 25,
        cv2.CAP_PROP_BUFFERSIZE: 2,
    }


def _sysfs(folder: Path) -> Path:
    """Make the sysfs files of a webcam with a second file, of another webcam, and of a Pi's codec."""
    nodes = {
        "video2": ("usb1/1-1", "HD Webcam", 0),
        "video3": ("usb1/1-1", "HD Webcam", 1),
        "video10": ("usb1/1-2", "Other", 0),
        "video11": ("platform/soc", "bcm2835-codec-decode", 0),
    }
    for node, (plug, name, index) in nodes.items():
        device = folder.parent / "devices" / plug
        device.mkdir(parents=True, exist_ok=True)
        (folder / node).mkdir(parents=True)
        (folder / node / "device").symlink_to(device)
        (folder / node / "name").write_text(f"{name}\n")
        (folder / node / "index").write_text(f"{index}\n")
    return folder


class TestTimes:
    def test_times_are_those_of_the_kernel(self, webcam: FakeWebcam) -> None:
        eye = open_camera(webcam)
        webcam.clock.pass_time(1.0)
        frame = eye.read()
        assert webcam.clock.now() - 1 / 60 - 0.02 <= frame.time <= webcam.clock.now() - 0.02 + 1e-6

    @pytest.mark.parametrize("offset_s", [-4000.0, 1.7e9])
    def test_times_are_those_of_arrival_with_another_clock(self, offset_s: float, webcam: FakeWebcam) -> None:
        webcam.stamp_offset_s = offset_s
        eye = open_camera(webcam)
        assert eye.read().time == webcam.clock.now()
        webcam.clock.pass_time(1.0)
        assert webcam.clock.now() - 1 / 60 <= eye.read().time <= webcam.clock.now()


class TestExposure:
    def test_exposure_is_locked_if_the_light_changes(self, webcam: FakeWebcam) -> None:
        eye = open_camera(webcam)
        assert webcam.controls[cv2.CAP_PROP_AUTO_EXPOSURE] == MANUAL
        assert webcam.controls[cv2.CAP_PROP_EXPOSURE] == pytest.approx(FOUND_UNITS, rel=0.03)
        assert webcam.controls[cv2.CAP_PROP_AUTO_WB] == 0
        assert webcam.controls[cv2.CAP_PROP_WB_TEMPERATURE] == FOUND_KELVIN
        webcam.lamp = 0.5
        webcam.clock.pass_time(0.1)
        assert eye.read().image[0, 0, 2] == RED_BGR[2] // 2

    @pytest.mark.parametrize("mode", [APERTURE_PRIORITY, 0])
    def test_exposure_follows_the_light_without_lock(self, mode: int, webcam: FakeWebcam) -> None:
        webcam.only_auto = mode
        eye = open_camera(webcam, lock=False)
        assert webcam.controls[cv2.CAP_PROP_AUTO_EXPOSURE] == mode
        webcam.lamp = 0.5
        webcam.clock.pass_time(1.0)
        assert eye.read().image[0, 0, 2] == RED_BGR[2]

    def test_exposure_is_set_in_the_kernels_units(self, webcam: FakeWebcam) -> None:
        open_camera(webcam, exposure_s=0.02, gain=7, white_balance_k=3000)
        assert webcam.controls == {
            cv2.CAP_PROP_AUTO_EXPOSURE: MANUAL,
            cv2.CAP_PROP_EXPOSURE: 200,
            cv2.CAP_PROP_AUTO_WB: 0,
            cv2.CAP_PROP_WB_TEMPERATURE: 3000,
            cv2.CAP_PROP_GAIN: 7,
        }

    def test_a_control_that_the_camera_refuses_is_logged(
        self, webcam: FakeWebcam, caplog: pytest.LogCaptureFixture, check_text: CheckText
    ) -> None:
        webcam.controls.clear()
        assert open_camera(webcam, exposure_s=0.02, gain=7).read()
        check_text("\n".join(caplog.messages))


class TestUnplugged:
    def test_lost_camera_is_reported_and_works_again_once_connected(self, webcam: FakeWebcam, raises: Raises) -> None:
        eye = open_camera(webcam)
        last = eye.read().sequence
        webcam.path.unlink()
        webcam.clock.pass_time(3.0)
        with raises(DeviceLostError):
            eye.read()
        assert webcam.captures[-1].is_released
        webcam.controls[cv2.CAP_PROP_EXPOSURE] = 10.0
        webcam.path.touch()
        webcam.clock.pass_time(5.0)
        assert eye.read().sequence > last
        assert tuple(eye.read().image[0, 0]) == RED_BGR
        assert webcam.controls[cv2.CAP_PROP_AUTO_EXPOSURE] == MANUAL

    def test_lost_camera_is_reported_also_while_its_file_exists(
        self, webcam: FakeWebcam, monkeypatch: pytest.MonkeyPatch, raises: Raises
    ) -> None:
        eye = open_camera(webcam)
        monkeypatch.setattr(webcam.captures[-1], "grab", lambda: False)
        webcam.clock.pass_time(0.1)
        with raises(DeviceLostError):
            eye.read()

    def test_a_replugged_camera_is_lost_while_it_cannot_be_opened(self, webcam: FakeWebcam, raises: Raises) -> None:
        eye = open_camera(webcam)
        webcam.path.unlink()
        webcam.clock.pass_time(0.1)
        webcam.path.touch()
        webcam.is_busy = True
        webcam.clock.pass_time(2.0)
        with raises(DeviceLostError):
            eye.read()

    def test_single_broken_pictures_are_skipped_and_many_are_a_failure(
        self, webcam: FakeWebcam, raises: Raises
    ) -> None:
        webcam.broken = 4
        assert open_camera(webcam).read().sequence == 0
        webcam.broken = 1000
        with raises(DeviceLostError):
            open_camera(webcam)


class TestOpening:
    @pytest.mark.parametrize("build_nodes", [_sysfs, Path], ids=["some", "none"])
    def test_a_missing_camera_is_reported_with_the_present_ones(
        self,
        build_nodes: Callable[[Path], Path],
        webcam: FakeWebcam,
        tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch,
        raises: Raises,
    ) -> None:
        monkeypatch.setattr("drivers.raspberrypi.cameras.v4l2.NODES", build_nodes(tmp_path / "class"))
        webcam.path.unlink()
        with raises(DeviceError):
            open_camera(webcam)

    def test_a_file_that_this_user_may_not_use_is_reported(
        self, webcam: FakeWebcam, monkeypatch: pytest.MonkeyPatch, raises: Raises
    ) -> None:
        monkeypatch.setattr("os.access", lambda *_: False)
        with raises(DeviceError):
            open_camera(webcam)

    def test_a_camera_that_another_program_uses_is_reported_and_closed(
        self, webcam: FakeWebcam, raises: Raises
    ) -> None:
        webcam.is_busy = True
        with raises(DeviceError):
            open_camera(webcam)
        assert webcam.captures[-1].is_released

    def test_an_opencv_without_v4l2_is_reported(
        self, webcam: FakeWebcam, monkeypatch: pytest.MonkeyPatch, raises: Raises
    ) -> None:
        monkeypatch.setattr(cv2.videoio_registry, "getCameraBackends", lambda: [cv2.CAP_GSTREAMER])
        with raises(DeviceError, "no-v4l2"):
            open_camera(webcam)


@pytest.mark.parametrize("device, path", [(0, "/dev/video0"), ("/dev/v4l/by-id/usb-x-video-index0",) * 2])
def test_the_wiring_names_the_file(device: str | int, path: str) -> None:
    assert UsbCamera(device=device).connections() == (Connection("camera", "USB", path),)


@pytest.mark.parametrize(
    "key, value, kind",
    [
        ("device", "video0", "invalid-value"),
        ("pixel_format", "jpeg", "wrong-value"),
        ("exposure_s", 15, "out-of-bounds"),
    ],
)
def test_a_mistake_in_a_file_is_reported_with_its_key(key: str, value: object, kind: str, raises: Raises) -> None:
    robot = ROVER.model_copy(update={"backends": {"raspberrypi": {"eye": {"driver": "v4l2", key: value}}}})
    with raises(DescriptionError, kind, key=f"raspberrypi.eye.{key}"):
        bind_devices(robot, "raspberrypi", ["eye"])

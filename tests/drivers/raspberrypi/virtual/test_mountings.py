"""Cameras and IMUs of a virtual Pi whose mounting differs from the robot's file."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from drivers.raspberrypi.cameras.csi import PiCamera
from drivers.raspberrypi.mpu6050 import MPU6050
from drivers.raspberrypi.virtual.mountings import mount_device
from robotcore.description import load_robot
from robotcore.hal.kind import build_sensor
from robotcore.kinds.camera import Frame
from robotcore.kinds.imu import ImuDescription, ImuSample

EYE = load_robot("rover").all_of("camera")[0]
GYRO = ImuDescription(kind="imu", name="gyro")


def see(**settings: Any) -> np.ndarray:
    """Return the picture of a camera that is mounted upright, and whose file has other settings."""
    image = np.arange(EYE.height_px * EYE.width_px * 3, dtype=np.uint32).astype(np.uint8)
    image = image.reshape(EYE.height_px, EYE.width_px, 3)
    image[0, 0] = (1, 2, 3)
    camera = build_sensor(EYE, lambda: Frame(image, 0.0, 0))
    mounted: Any = mount_device(camera, EYE, {"eye": PiCamera(**settings)}, {"eye": PiCamera()})
    shown: np.ndarray = mounted.read().image
    assert not shown.flags.writeable or shown is image
    return shown


def test_wrong_settings_of_a_camera_move_and_swap_its_pixels() -> None:
    assert see()[0, 0].tolist() == [1, 2, 3]
    assert see(flip_horizontal=True)[0, -1].tolist() == [1, 2, 3]
    assert see(flip_vertical=True)[-1, 0].tolist() == [1, 2, 3]
    assert see(rotate_180=True)[-1, -1].tolist() == [1, 2, 3]
    assert see(swap_red_blue=True)[0, 0].tolist() == [3, 2, 1]


@pytest.mark.parametrize(
    "settings,expected",
    [
        ({}, (0.5, 1.0, 2.0, 0.1)),
        ({"is_upside_down": True}, (-0.5, 1.0, -2.0, -0.1)),
        ({"forward_axis": "y"}, (0.5, 2.0, -1.0, 0.1)),
        ({"forward_axis": "-x"}, (0.5, -1.0, -2.0, 0.1)),
    ],
)
def test_wrong_settings_of_an_imu_turn_its_axes(settings: dict[str, Any], expected: tuple[float, ...]) -> None:
    imu = build_sensor(GYRO, lambda: ImuSample(0.5, 1.0, 2.0, 0.1, 0.0, 0))
    mounted: Any = mount_device(imu, GYRO, {"gyro": MPU6050(**settings)}, {"gyro": MPU6050()})
    sample = mounted.read()
    found = (sample.yaw_rate, sample.forward_acceleration, sample.left_acceleration, sample.heading)
    assert found == pytest.approx(expected)

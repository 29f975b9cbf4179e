"""Cameras and IMUs whose mounting or format differs from the settings in the robot's file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from operator import xor

import numpy as np

from drivers.raspberrypi.cameras.capture import CameraDriver
from drivers.raspberrypi.polled_imu import TURNS, ImuDriver
from robotcore.description import DeviceDescription
from robotcore.geometry import wrap_angle
from robotcore.hal.device import Device
from robotcore.hal.kind import build_sensor
from robotcore.hardware import DeviceDriver
from robotcore.kinds.camera import Camera, Frame
from robotcore.kinds.imu import Imu, ImuSample


def mount_device(
    device: Device,
    description: DeviceDescription,
    own: Mapping[str, DeviceDriver],
    true: Mapping[str, DeviceDriver],
) -> Device:
    """Return a simulated device whose samples are those that the driver of the robot's file makes of the hardware's.

    own: the drivers in the robot's file, by the names of the devices.
    true: the drivers in the file of the true robot, whose settings fit the hardware.
    """
    match device, own.get(device.name), true.get(device.name):
        case Camera() as camera, CameraDriver() as in_use, CameraDriver() as fitting:
            return _mount_camera(camera, description, in_use, fitting)
        case Imu() as imu, ImuDriver() as in_use, ImuDriver() as fitting:
            return _mount_imu(imu, description, in_use, fitting)
    return device


def _mount_camera(camera: Camera, description: DeviceDescription, own: CameraDriver, true: CameraDriver) -> Device:
    is_reversed = [*map(xor, own.transformation, true.transformation)]
    if not any(is_reversed):
        return camera
    parts = tuple(slice(None, None, -1 if each else 1) for each in is_reversed)
    last: tuple[int, Frame] | None = None

    def read() -> Frame:
        nonlocal last
        frame = camera.read()
        if last is None or last[0] != frame.sequence:
            image = np.ascontiguousarray(frame.image[parts])
            image.flags.writeable = False
            last = frame.sequence, Frame(image, frame.time, frame.sequence)
        return last[1]

    return build_sensor(description, read, camera.close)


def _mount_imu(imu: Imu, description: DeviceDescription, own: ImuDriver, true: ImuDriver) -> Device:
    if (own.forward_axis, own.is_upside_down) == (true.forward_axis, true.is_upside_down):
        return imu
    up, true_up = (-1 if each.is_upside_down else 1 for each in (own, true))
    (along_x, along_y), (true_x, true_y) = TURNS[own.forward_axis], TURNS[true.forward_axis]

    def read() -> ImuSample:
        sample = imu.read()
        forward, left = sample.forward_acceleration, true_up * sample.left_acceleration
        x, y = true_x * forward - true_y * left, true_y * forward + true_x * left  # along the axes of the chip
        return replace(
            sample,
            yaw_rate=up * true_up * sample.yaw_rate,
            forward_acceleration=along_x * x + along_y * y,
            left_acceleration=up * (along_x * y - along_y * x),
            heading=wrap_angle(up * true_up * sample.heading),
        )

    return build_sensor(description, read, imu.close)

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from robotcore.hal.backend import Setup
from robotcore.hal.device import Device
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Camera, Frame
from robotcore.optics import Image, Intrinsics
from tests.robotcore.testing.broken.sensing import Damage, change_description, change_samples
from tests.robotcore.testing.harness import Sound, broken, replace_attribute


def change_pictures(change: Callable[[Image], Any]) -> Damage:
    """Change every picture, and leave it read-only."""

    def change_frame(frame: Frame) -> Frame:
        image = change(frame.image)
        image.flags.writeable = False
        return Frame(image, frame.time, frame.sequence)

    return change_samples(Camera, change_frame)


def add_alpha(image: Image) -> Image:
    return np.dstack([image, np.full(image.shape[:2], 255, dtype=np.uint8)])


def make_writable(frame: Frame) -> Frame:
    return Frame(frame.image.copy(), frame.time, frame.sequence)


def share_one_buffer(robot: Robot) -> None:
    for camera in robot.devices.values():
        if isinstance(camera, Camera):
            buffer = np.empty((camera.intrinsics.height, camera.intrinsics.width, 3), dtype=np.uint8)
            replace_attribute(camera, "_newest", _into(buffer, camera._newest))


def _into(buffer: Image, newest: Callable[[], Frame]) -> Callable[[], Frame]:
    def overwrite() -> Frame:
        frame = newest()
        buffer[:] = frame.image
        view = buffer.view()
        view.flags.writeable = False
        return Frame(view, frame.time, frame.sequence)

    return overwrite


class WrongIntrinsicsCamera(Camera):
    """A camera with wrong intrinsics."""

    def __init__(self, inner: Camera, intrinsics: Intrinsics) -> None:
        super().__init__(inner.name, intrinsics)
        self._inner = inner

    def _newest(self) -> Frame:
        return self._inner.read()


class WrongIntrinsicsSuite(Sound):
    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        devices = [self.replace_camera(device) for device in robot.devices.values()]
        return Robot(robot.name, robot.clock, devices, truth=robot.truth, release=robot.close)

    def replace_camera(self, device: Device) -> Device:
        return WrongIntrinsicsCamera(device, Intrinsics(640, 480, 1.0821)) if isinstance(device, Camera) else device


class WideFieldSuite(WrongIntrinsicsSuite):
    def open(self, setup: Setup) -> Robot:
        return super().open(change_description("eye", horizontal_fov_rad=1.4)(setup))

    def replace_camera(self, device: Device) -> Device:
        return WrongIntrinsicsCamera(device, self.eye.intrinsics) if isinstance(device, Camera) else device


BROKEN = (
    broken(
        "pictures are mirrored",
        "left_of_the_world_is_left_in_the_picture",
        change_pictures(lambda image: np.ascontiguousarray(image[:, ::-1])),
    ),
    broken(
        "pictures are upside down",
        "floor_is_at_the_bottom",
        change_pictures(lambda image: np.ascontiguousarray(image[::-1])),
    ),
    broken(
        "colours are RGB",
        "channels_are_blue_green_red",
        change_pictures(lambda image: np.ascontiguousarray(image[:, :, ::-1])),
    ),
    broken(
        "pictures have an alpha channel",
        "picture_is_uint8_of_height_width_and_three_channels",
        change_pictures(add_alpha),
    ),
    broken(
        "pictures are floats",
        "picture_is_uint8_of_height_width_and_three_channels",
        change_pictures(lambda image: image.astype(np.float32)),
    ),
    broken("pictures can be written to", "picture_is_read_only", change_samples(Camera, make_writable)),
    broken("pictures are column-major", "picture_is_contiguous", change_pictures(np.asfortranarray)),
    broken("all pictures lie in one buffer", "pictures_do_not_share_their_memory", share_one_buffer),
    broken(
        "the field of view is narrower than described", "field_of_view_equals_the_description", suite=WideFieldSuite
    ),
    broken("the intrinsics are those of another size", "intrinsics_equal_the_description", suite=WrongIntrinsicsSuite),
)

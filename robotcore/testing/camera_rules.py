"""Rules for cameras: the shape, the channels, the memory and the field of view of pictures."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.description import WorldDescription
from robotcore.geometry import Pose
from robotcore.hal.robot import Role
from robotcore.kinds.camera import CameraDescription, Frame
from robotcore.optics import CameraView
from robotcore.testing import worlds
from robotcore.testing.bench import TestBench, TestSupport, sleep

MIN_PIXELS = 20
"""The number of green pixels that a picture of a green object must have."""

COLOUR_LEAD = 25
"""A pixel is green if its green value exceeds its blue and red values by more than this, of 255."""


class CameraRules(TestBench):
    """Rules for the driver of a camera."""

    @property
    def eye(self) -> CameraDescription:
        """The description of the robot's first camera. If there is none, the rule is skipped."""
        found = self.description.first_of(CameraDescription)
        return found or pytest.skip(f"{self.description.name} has no camera")

    def test_picture_is_uint8_of_height_width_and_three_channels(self) -> None:
        image = self._read_frame(None).image
        expected = (self.eye.height_px, self.eye.width_px, 3)
        assert image.shape == expected and image.dtype == np.uint8, (  # noqa: PT018  one fact
            f"the driver returned a picture of {image.dtype} and shape {image.shape}. Return uint8 of shape "
            f"{expected}: height, width, 3 channels"
        )

    def test_picture_is_read_only(self) -> None:
        image = self._read_frame(None).image
        assert not image.flags.writeable, (
            "the driver returned a writable picture. Set image.flags.writeable = False, because several readers "
            "share the picture"
        )

    def test_picture_is_contiguous(self) -> None:
        image = self._read_frame(None).image
        assert image.flags.c_contiguous, (
            "the driver returned a picture that is not contiguous in memory. Return np.ascontiguousarray(image)"
        )

    def test_pictures_do_not_share_their_memory(self) -> None:
        with self.open_robot(None, Role.CAMERA) as robot:
            first = robot.camera.read()
            sleep(robot, 0.5)
            second = robot.camera.read()
        assert first.sequence == second.sequence or not np.shares_memory(first.image, second.image), (
            "the driver returned two pictures in the same memory, so the second overwrote the first. "
            "Return a copy of the buffer"
        )

    def test_intrinsics_equal_the_description(self) -> None:
        with self.open_robot(None, Role.CAMERA) as robot:
            got = robot.camera.intrinsics
        assert got == self.eye.intrinsics, (
            f"the camera has {got}. Give it the described intrinsics, {self.eye.intrinsics}"
        )

    def test_channels_are_blue_green_red(self) -> None:
        world = worlds.box(self.eye.mount, 0.6, "blue")
        box = world.obstacles[0]
        column, row = self._project(box.x_m, box.y_m, box.height_m / 2)
        patch = self._read_frame(world).image[row - 3 : row + 4, column - 3 : column + 4]
        blue, red = np.median(patch[:, :, 0]), np.median(patch[:, :, 2])
        assert blue > red + COLOUR_LEAD, (
            f"a blue box has {blue:.0f} in channel 0 and {red:.0f} in channel 2. Return the channels in the order "
            "blue, green, red"
        )

    @pytest.mark.parametrize("side", ["left", "right"])
    def test_left_of_the_world_is_left_in_the_picture(self, side: str) -> None:
        bearing = self._side_bearing if side == "left" else -self._side_bearing
        column, _ = self._find_green(worlds.ball(self.eye.mount, 0.9, bearing))
        assert (column < self.eye.intrinsics.cx) == (side == "left"), (
            f"a green ball on the {side} appeared in column {column:.0f} of {self.eye.width_px}, which is the other "
            "half. Do not mirror the picture"
        )

    def test_floor_is_at_the_bottom(self) -> None:
        world = worlds.box(self.eye.mount, 0.6, "green")
        box = world.obstacles[0]
        expected = self._project(box.x_m, box.y_m, box.height_m / 2)[1]
        _, row = self._find_green(world)
        assert abs(row - expected) < abs(self.eye.height_px - 1 - row - expected), (
            f"a low green box appeared in row {row:.0f} of {self.eye.height_px} instead of about row {expected}. "
            "Return the top row of the picture first"
        )

    def test_field_of_view_equals_the_description(self) -> None:
        balls = [worlds.ball(self.eye.mount, 0.9, bearing) for bearing in (-self._side_bearing, self._side_bearing)]
        right, left = (self._find_green(world)[0] for world in balls)
        at_right, at_left = (
            self._project(world.targets[0].x_m, world.targets[0].y_m, worlds.BALL_RADIUS_M)[0] for world in balls
        )
        assert abs(right - left) == pytest.approx(at_right - at_left, rel=0.03, abs=3), (
            f"balls {self._side_bearing:.2f} rad left and right of the axis appeared {abs(right - left):.0f} px apart "
            f"instead of {at_right - at_left} px. Let the width of the picture show the full angle "
            f"horizontal_fov_rad, {self.eye.horizontal_fov_rad} rad"
        )

    @property
    def _side_bearing(self) -> float:
        """A bearing well within the picture, in radians."""
        return 0.28 * self.eye.horizontal_fov_rad

    def _read_frame(self, world: WorldDescription | None) -> Frame:
        if world:
            self.require(TestSupport.WORLD)
        with self.open_robot(world, Role.CAMERA) as robot:
            sleep(robot, 0.2)
            return robot.camera.read()

    def _find_green(self, world: WorldDescription) -> tuple[float, float]:
        """Return the column and the row of the centre of the green pixels."""
        blue, green, red = (self._read_frame(world).image[:, :, i].astype(int) for i in range(3))
        rows, columns = np.nonzero(green > np.maximum(blue, red) + COLOUR_LEAD)
        assert len(rows) >= MIN_PIXELS, (
            f"the picture of a green object has {len(rows)} green pixels. Show the world's objects in their colours"
        )
        return float(columns.mean()), float(rows.mean())

    def _project(self, x: float, y: float, z: float) -> tuple[int, int]:
        """Return the column and the row of a point of the world, in metres, in the described camera's picture."""
        view = CameraView.of(self.eye.intrinsics, self.eye.mount, Pose(0.0, 0.0, 0.0))
        column, row = view.to_pixels(view.to_camera(np.array([[x, y, z]])))[0]
        return round(column), round(row)

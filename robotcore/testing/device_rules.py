"""Rules for displays and encoders."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from robotcore.hal.robot import Role
from robotcore.testing.bench import TestBench, TestSupport, sleep

SHAPES = {"colour": (48, 64, 3), "grey": (48, 64)}


class DisplayRules(TestBench):
    """Rules for the driver of a display."""

    @pytest.mark.parametrize("kind", SHAPES)
    def test_display_accepts_a_read_only_picture(self, kind: str) -> None:
        picture = np.full(SHAPES[kind], 99, dtype=np.uint8)
        picture.flags.writeable = False
        with self.open_robot(None, Role.DISPLAY) as robot:
            try:
                robot.display.show(picture)
            except Exception as error:  # noqa: BLE001  any exception is an error of the driver
                pytest.fail(
                    f"{robot.display.name}: show() of a read-only {kind} picture raised {error!r}. "
                    "Show colour and grey pictures, and do not write into them"
                )

    def test_display_does_not_change_the_picture(self) -> None:
        picture = np.arange(48 * 64 * 3, dtype=np.uint32).astype(np.uint8).reshape(48, 64, 3)
        shown = picture.copy()
        with self.open_robot(None, Role.DISPLAY) as robot:
            robot.display.show(shown)
        assert np.array_equal(shown, picture), "show() changed the app's picture. Draw on a copy of the picture"


SPEED_RAD_S = 4.0

STEP_S = 0.1
"""The time between two readings of an encoder, in seconds."""

JITTER_RAD = 0.1
"""An encoder may count back by less than this angle while its wheel turns, in radians."""


class EncoderRules(TestBench):
    """Rules for the driver of a drive's encoders."""

    def test_encoders_begin_at_zero(self) -> None:
        with self.open_robot(None, Role.DRIVE) as robot:
            for encoder in self.get_encoders(robot):
                assert (angle := encoder.read().angle) == pytest.approx(0, abs=0.02), (
                    f"{encoder.name} returned {angle:+.3f} rad just after the robot was opened. "
                    "Count angles from the opening"
                )

    @pytest.mark.parametrize("sign", [1, -1], ids=["forward", "backward"])
    def test_encoders_count_forward_as_positive(self, sign: int) -> None:
        left, right = self._measure_turn(sign * SPEED_RAD_S, sign * SPEED_RAD_S)
        assert sign * left > 0 < sign * right, (
            f"both motors were commanded {sign * SPEED_RAD_S:+} rad/s, and the encoders counted {left:+.2f} rad on the "
            f"left and {right:+.2f} rad on the right. Look at each wheel whose count has the wrong sign: if it turns "
            "the wrong way, negate its motor, else its encoder"
        )

    def test_each_encoder_counts_its_own_wheel(self) -> None:
        if self.drive.steering_servo:
            pytest.skip("the wheels of a drive that steers roll along one arc")
        left, right = self._measure_turn(SPEED_RAD_S, 0.0)
        assert abs(left) > 3 * abs(right), (
            f"only the left motor was commanded to turn. The left encoder counted {left:+.2f} rad and the right one "
            f"{right:+.2f} rad. Let each encoder count the turns of its own wheel"
        )

    def test_angles_are_in_radians(self) -> None:
        for angle in self._measure_turn(SPEED_RAD_S, SPEED_RAD_S):
            assert abs(angle) == pytest.approx(SPEED_RAD_S, rel=0.03), (
                f"an encoder counted {abs(angle):.3f} in 1 s at {SPEED_RAD_S} rad/s. Return the angle of the wheel "
                "in radians, within 3 %"
            )

    def test_angles_count_beyond_a_turn(self) -> None:
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            encoders = self.get_encoders(robot)
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
            angles = [[encoder.read().angle for encoder in encoders]]
            for _ in range(math.ceil(1.2 * math.tau / SPEED_RAD_S / STEP_S)):
                sleep(robot, STEP_S)
                angles.append([encoder.read().angle for encoder in encoders])
        for encoder, counted in zip(encoders, zip(*angles, strict=True), strict=True):
            steps = [now - then for then, now in pairwise(counted)]
            assert -min(steps) < JITTER_RAD or max(steps) < JITTER_RAD, (
                f"the wheel turned in one direction, and {encoder.name} counted {max(steps):+.2f} rad and "
                f"{min(steps):+.2f} rad in {STEP_S} s. Add the whole turns, so that the angle does not jump back"
            )

    def _measure_turn(self, left_rad_s: float, right_rad_s: float) -> tuple[float, float]:
        """Turn the wheels at these velocities, and return the angle that each encoder counted in 1 s, in radians."""
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            left, right = self.get_encoders(robot)
            self.command_wheels(robot, left_rad_s, right_rad_s)
            left_then, right_then = left.read().angle, right.read().angle
            sleep(robot, 1.0)
            return left.read().angle - left_then, right.read().angle - right_then

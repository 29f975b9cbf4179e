"""Rules for batteries, displays and encoders."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.hal.devices import Battery
from robotcore.hal.robot import Robot, Role
from robotcore.testing.bench import TestBench, TestSupport, sleep

FRESH_S = 5.0
"""The time in seconds within which a battery must have a new sample. Other sensors must be faster."""


class BatteryRules(TestBench):
    """The rules for batteries whose voltage a board measures."""

    def test_voltage_is_a_number_above_zero(self) -> None:
        with self.open_robot() as robot:
            batteries = self._batteries(robot)
            sleep(robot, FRESH_S)
            for battery in batteries:
                voltage = battery.read().voltage
                assert math.isfinite(voltage), f"{battery.name}: reads {voltage} V; raise DeviceError instead"
                assert voltage > 0, f"{battery.name}: reads {voltage} V; return volts, above zero"

    def test_voltage_is_measured_regularly(self) -> None:
        with self.open_robot() as robot:
            before = {battery.name: battery.read().time for battery in self._batteries(robot)}
            sleep(robot, FRESH_S)
            for battery in self._batteries(robot):
                assert (time := battery.read().time) > before[battery.name], (
                    f"{battery.name}: {FRESH_S:g} s later the newest sample is of {time} s; measure it regularly"
                )

    def _batteries(self, robot: Robot) -> list[Battery]:
        found = [device for device in robot.devices.values() if isinstance(device, Battery)]
        return found or pytest.skip(f"{self.backend.name} opens no battery of {self.description.name}")


SHAPES = {"colour": (48, 64, 3), "grey": (48, 64)}


class DisplayRules(TestBench):
    """The rules for displays."""

    @pytest.mark.parametrize("kind", SHAPES)
    def test_display_accepts_a_read_only_picture(self, kind: str) -> None:
        picture = np.full(SHAPES[kind], 99, dtype=np.uint8)
        picture.flags.writeable = False
        with self.open_robot(None, Role.DISPLAY) as robot:
            try:
                robot.display.show(picture)
            except Exception as error:  # noqa: BLE001  any exception is a fault of the driver
                pytest.fail(f"{robot.display.name}: a read-only picture in {kind} raised {error!r}")

    def test_display_does_not_change_the_picture(self) -> None:
        picture = np.arange(48 * 64 * 3, dtype=np.uint32).astype(np.uint8).reshape(48, 64, 3)
        shown = picture.copy()
        with self.open_robot(None, Role.DISPLAY) as robot:
            robot.display.show(shown)
        assert np.array_equal(shown, picture), "show() changed the picture of the app; work on a copy"


SPEED_RAD_S = 4.0


class EncoderRules(TestBench):
    """The rules for encoders on a drive."""

    def test_encoders_begin_at_zero(self) -> None:
        with self.open_robot(None, Role.DRIVE) as robot:
            for encoder in self.get_encoders(robot):
                assert (angle := encoder.read().angle) == pytest.approx(0, abs=0.02), (
                    f"{encoder.name}: reads {angle:+.3f} rad just after opening; count angles from the opening"
                )

    def test_encoders_count_forward_as_positive(self) -> None:
        left, right = self._measure_turn(SPEED_RAD_S, SPEED_RAD_S)
        assert left > 0 < right, (
            f"both motors were commanded +{SPEED_RAD_S} rad/s and the encoders moved by {left:+.2f} and "
            f"{right:+.2f} rad; driving forward must count up on both sides"
        )

    def test_each_encoder_counts_its_own_wheel(self) -> None:
        left, right = self._measure_turn(SPEED_RAD_S, 0.0)
        assert abs(left) > 3 * abs(right), (
            f"only the left motor was commanded to turn; the left encoder moved by {left:+.2f} rad, the right one "
            f"by {right:+.2f}: are they swapped?"
        )

    def test_angles_are_in_radians(self) -> None:
        for angle in self._measure_turn(SPEED_RAD_S, SPEED_RAD_S):
            assert abs(angle) == pytest.approx(SPEED_RAD_S, rel=0.03), (
                f"1 s at {SPEED_RAD_S} rad/s counted {abs(angle):.3f}; expected {SPEED_RAD_S} rad within 3 %"
            )

    def _measure_turn(self, left_rad_s: float, right_rad_s: float) -> tuple[float, float]:
        """Command these wheel velocities for one second, and return the rotation of both encoders, in radians."""
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            left, right = self.get_encoders(robot)
            self.command_wheels(robot, left_rad_s, right_rad_s)
            left_then, right_then = left.read().angle, right.read().angle
            sleep(robot, 1.0)
            return left.read().angle - left_then, right.read().angle - right_then

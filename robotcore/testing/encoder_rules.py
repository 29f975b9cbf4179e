"""Rules for encoders: forward is positive, each counts its own wheel, radians since opening."""

from __future__ import annotations

import pytest

from robotcore.hal.robot import Role
from robotcore.testing.bench import Bench, Capability, let_pass

SPEED_RAD_S = 4.0


class EncoderRules(Bench):
    """What every encoder on a drive owes."""

    def test_encoders_begin_at_zero(self) -> None:
        with self.opened(None, Role.DRIVE) as robot:
            for encoder in self.encoders(robot):
                assert (angle := encoder.read().angle) == pytest.approx(0, abs=0.02), (
                    f"{encoder.name}: reads {angle:+.3f} rad just after opening; angles count from there"
                )

    def test_encoders_count_forward_as_positive(self) -> None:
        left, right = self._turned_by(SPEED_RAD_S, SPEED_RAD_S)
        assert left > 0 < right, (
            f"both motors were told +{SPEED_RAD_S} rad/s and the encoders moved by {left:+.2f} and {right:+.2f} rad; "
            "driving forward must count up on both sides"
        )

    def test_each_encoder_counts_its_own_wheel(self) -> None:
        left, right = self._turned_by(SPEED_RAD_S, 0.0)
        assert abs(left) > 3 * abs(right), (
            f"only the left motor was told to turn; the left encoder moved by {left:+.2f} rad, the right one "
            f"by {right:+.2f}: are they swapped?"
        )

    def test_angles_are_in_radians(self) -> None:
        for angle in self._turned_by(SPEED_RAD_S, SPEED_RAD_S):
            assert abs(angle) == pytest.approx(SPEED_RAD_S, rel=0.03), (
                f"1 s at {SPEED_RAD_S} rad/s counted {abs(angle):.3f}; expected {SPEED_RAD_S} rad within 3 %"
            )

    def _turned_by(self, left_rad_s: float, right_rad_s: float) -> tuple[float, float]:
        """Return by how much the two encoders move in a second at these velocities."""
        self.require(Capability.MOTION)
        with self.opened(None, Role.DRIVE) as robot:
            left, right = self.encoders(robot)
            self.command(robot, left_rad_s, right_rad_s)
            left_then, right_then = left.read().angle, right.read().angle
            let_pass(robot, 1.0)
            return left.read().angle - left_then, right.read().angle - right_then

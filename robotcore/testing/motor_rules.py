"""Rules for motors: units, signs, left and right, limits, waiting, and NaN and infinite velocities."""

from __future__ import annotations

import math
from functools import partial

import pytest

from robotcore.errors import InvalidCommandError
from robotcore.hal.robot import Role
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.testing.bench import (
    MAX_CALL_S,
    SETTLING_S,
    STANDSTILL_M,
    UNPLUGGED_S,
    TestBench,
    TestSupport,
    measure_time,
    raises_in_time,
)
from robotcore.testing.fakes import CommandSpy, Gate

SPEED_RAD_S = 4.0

SHARES = (0.12, 0.93, -0.93)
"""The tested velocities, as shares of ``max_velocity``. For the usual limits they are no whole numbers of rad/s."""

RESOLUTION_RAD_S = 0.15
"""The velocity of a slow wheel may differ from its command by this much, in rad/s."""


class MotorRules(TestBench):
    """Rules for the driver of a drive's motors."""

    def test_positive_velocity_drives_forward(self) -> None:
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
            motion = self.measure_motion(robot, 1.0)
        assert motion.forward > 0, (
            f"both motors were commanded +{SPEED_RAD_S} rad/s, and the robot moved {motion.forward:+.3f} m. "
            "Negate the velocity of each motor that turns backward, so that the robot moves forward"
        )

    def test_left_motor_faster_turns_right(self) -> None:
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S / 2)
            motion = self.measure_motion(robot, 1.0)
        assert motion.turn < 0, (
            f"the left motor was commanded the higher velocity, and the heading changed by {motion.turn:+.3f} rad "
            "instead of a negative angle. Check whether the motors are swapped, and the sign of the heading"
        )

    def test_wheels_turn_at_the_commanded_velocity(self) -> None:
        self.require(TestSupport.MOTION)
        radius = self.drive.wheel_radius_m
        with self.open_robot(None, Role.DRIVE) as robot:
            limit = min(motor.max_velocity for motor in self.get_motors(robot))
            for commanded in (share * limit for share in SHARES):
                self.command_wheels(robot, commanded, commanded)
                moved = self.measure_motion(robot, 1.0).forward
                assert moved / radius == pytest.approx(commanded, rel=0.03, abs=RESOLUTION_RAD_S), (
                    f"in 1 s at {commanded:+.2f} rad/s the robot moved {moved:+.4f} m instead of "
                    f"{commanded * radius:+.4f} m. Turn its wheels, of radius {radius} m, at the commanded rad/s, "
                    "slow and fast, forward and backward. If it is too fast for them, set a lower max_velocity"
                )

    def test_stop_brings_the_wheels_to_rest(self) -> None:
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
            for motor in self.get_motors(robot):
                motor.stop()
            self.measure_motion(robot, SETTLING_S)
            motion = self.measure_motion(robot, SETTLING_S)
        assert math.hypot(motion.forward, motion.left) < STANDSTILL_M, (
            f"{SETTLING_S} s after stop() the robot still moved {motion.forward:+.4f} m in {SETTLING_S} s. "
            f"Bring its wheels to rest within {SETTLING_S} s"
        )

    def test_velocity_within_the_limits_is_returned_unchanged(self) -> None:
        with self.open_robot(None, Role.DRIVE) as robot:
            for motor in self.get_motors(robot):
                requested = motor.max_velocity / 2
                assert (sent := motor.set_velocity(requested)) == pytest.approx(requested, rel=0.05), (
                    f"{motor.name}: set_velocity({requested}) returned {sent} rad/s. Send and return the requested "
                    "velocity within 5 %, because it is below max_velocity"
                )

    @pytest.mark.parametrize("sign", [1, -1], ids=["forward", "backward"])
    def test_velocity_beyond_the_limit_is_clamped_and_returned(self, sign: int) -> None:
        with self.open_robot(None, Role.DRIVE) as robot:
            for motor in self.get_motors(robot):
                spy, limit = CommandSpy(motor), motor.max_velocity
                returned = motor.set_velocity(sign * 2 * limit)
                assert returned == pytest.approx(sign * limit), (
                    f"{motor.name}: set_velocity({sign * 2 * limit}) returned {returned} rad/s. "
                    f"Return the velocity at the limit, {sign * limit} rad/s"
                )
                assert abs(spy.last) <= limit, (
                    f"{motor.name}: the driver sent {spy.last} rad/s. Limit the velocity to max_velocity, "
                    f"{limit} rad/s, before it is sent"
                )

    def test_limit_does_not_exceed_the_description(self) -> None:
        described = {motor.name: motor.max_velocity_rad_s for motor in self.description.all_of(MotorDescription)}
        with self.open_robot(None, Role.DRIVE) as robot:
            limits = {motor.name: motor.max_velocity for motor in self.get_motors(robot)}
        for name, limit in limits.items():
            assert limit <= described[name], (
                f"{name}: max_velocity is {limit} rad/s. Set it to the described limit or less, {described[name]} rad/s"
            )

    def test_command_does_not_wait_for_hardware(self) -> None:
        gate = Gate()
        with self.open_gated(self.build_setup(), gate) as robot:
            for motor in self.get_motors(robot):
                assert not gate.blocks(partial(_send_several, motor)), (
                    f"{motor.name}: set_velocity() waited for the hardware, so slow hardware delays every tick. Store "
                    "the velocity, and send it in a thread of the driver"
                )
                fastest_s = min(measure_time(partial(motor.set_velocity, rad_s)) for rad_s in (4.0, 2.0, 1.0))
                assert fastest_s < MAX_CALL_S, (
                    f"{motor.name}: set_velocity() took {1000 * fastest_s:.0f} ms, which delays every tick. Store the "
                    f"velocity within {1000 * MAX_CALL_S:.0f} ms, and send it in a thread of the driver"
                )

    def test_command_to_unplugged_hardware_is_an_error(self) -> None:
        with self.open_unplugged(Role.DRIVE) as robot:
            for motor in self.get_motors(robot):
                assert raises_in_time(robot, partial(motor.set_velocity, SPEED_RAD_S)), (
                    f"{motor.name}: set_velocity() raised no error in {UNPLUGGED_S:g} s without hardware. Raise the "
                    "error of the last command in the next one, as DeviceError"
                )

    @pytest.mark.parametrize("velocity", [math.nan, math.inf, -math.inf])
    def test_velocity_that_is_not_finite_is_refused(self, velocity: float) -> None:
        with self.open_robot(None, Role.DRIVE) as robot:
            for motor in self.get_motors(robot):
                try:
                    sent = motor.set_velocity(velocity)
                except InvalidCommandError:
                    continue
                pytest.fail(f"{motor.name}: set_velocity({velocity}) returned {sent}. Raise InvalidCommandError")

    def test_refused_velocity_stops_the_motor(self) -> None:
        with self.open_robot(None, Role.DRIVE) as robot:
            for motor in self.get_motors(robot):
                spy = CommandSpy(motor)
                motor.set_velocity(SPEED_RAD_S)
                try:
                    motor.set_velocity(math.nan)
                except Exception:  # noqa: BLE001  another rule checks the class of the error
                    assert spy.last == 0, (
                        f"{motor.name}: after set_velocity(nan) raised an error, the last velocity sent is "
                        f"{spy.last} rad/s. Stop the motor before you raise the error"
                    )


def _send_several(motor: Motor) -> None:
    """Send two velocities, because a driver may store the first one and wait with the second."""
    motor.set_velocity(SPEED_RAD_S)
    motor.set_velocity(SPEED_RAD_S / 2)

"""A motor of a wheel."""

from __future__ import annotations

import math
from abc import ABC
from typing import Annotated, Any, Literal, Protocol

from pydantic import AfterValidator, Field, model_validator

from robotcore.description import DeviceDescription, Ideal
from robotcore.errors import InvalidCommandError, Mistake
from robotcore.hal.device import Actuator, build_invalid_command
from robotcore.hal.kind import Kind
from robotcore.kinds.device_tests.wheels import test_motors

__all__ = ["KIND", "Motor", "MotorDescription"]

MIN_LAG_S = 1e-4
"""The shortest lag other than 0, in seconds. Simulators have longer time steps, so a shorter lag has no effect."""


MAX_DEAD_BAND = 0.9
"""The greatest dead band, as a share of the greatest velocity. Beyond it, tiny commands would turn the wheel fast."""


def _require_measurable_lag(lag: float) -> float:
    if 0 < lag < MIN_LAG_S:
        problem = f"is {lag:g} s, shorter than a simulator's time step"
        raise Mistake(problem, f"Use 0, or at least {MIN_LAG_S:g} s", kind="lag-too-short")
    return lag


Gain = Annotated[float, Field(ge=0.1, le=2), Ideal(1.0)]


class MotorDescription(DeviceDescription):
    """A motor of a wheel. The wheel's velocity follows the command with a first-order lag.

    The dead band and the gains are the errors that remain behind the motor's driver. Simulators simulate them, and a
    run compensates them, in a simulator and on a robot.

    >>> motor = MotorDescription(
    ...     kind="motor", name="left_motor", max_velocity_rad_s=10.0, dead_band_rad_s=2.0, backward_gain=0.9
    ... )
    >>> motor.respond(6.0), motor.respond(-10.0), motor.respond(1.5)
    (5.0, -9.0, 0.0)
    >>> motor.compensate(5.0), motor.compensate(-9.0)
    (6.0, -10.0)
    """

    kind: Literal["motor"]
    max_velocity_rad_s: Annotated[float, Field(ge=0.001, le=1e4)]
    """The greatest velocity of the wheel, forward and backward, in rad/s."""
    lag_s: Annotated[float, Field(ge=0, le=10), AfterValidator(_require_measurable_lag), Ideal(0.0)] = 0.05
    """The time constant of the wheel's lag, in seconds."""
    dead_band_rad_s: Annotated[float, Field(ge=0, le=1e3), Ideal(0.0)] = 0.0
    """The greatest commanded velocity at which the wheel does not turn, in rad/s."""
    forward_gain: Gain = 1.0
    """The velocity of the wheel at the command ``max_velocity_rad_s``, divided by the command."""
    backward_gain: Gain = 1.0
    """The velocity of the wheel at the command -``max_velocity_rad_s``, divided by the command."""
    max_torque_nm: Annotated[float, Field(ge=1e-6, le=1e4)] = 0.08
    """The greatest torque at the wheel, in N·m."""

    @model_validator(mode="after")
    def _require_range(self) -> MotorDescription:
        if self.dead_band_rad_s > MAX_DEAD_BAND * self.max_velocity_rad_s:
            problem = (
                f"dead_band_rad_s, {self.dead_band_rad_s:g} rad/s, is more than {MAX_DEAD_BAND:.0%} of "
                f"max_velocity_rad_s, {self.max_velocity_rad_s:g} rad/s"
            )
            raise Mistake(problem, "Correct one of them", kind="dead-band-too-wide")
        return self

    def arguments(self) -> dict[str, Any]:
        return {"max_velocity": self.max_velocity_rad_s}

    def respond(self, rad_s: float) -> float:
        """Return the velocity that the wheel reaches after the lag, in rad/s: zero in the dead band, linear above it.

        rad_s: the commanded velocity in rad/s.
        """
        if not self.dead_band_rad_s:
            return self._select_gain(rad_s) * rad_s
        above = max(0.0, abs(rad_s) - self.dead_band_rad_s)
        return math.copysign(self._select_gain(rad_s) * above / self._linear_share, rad_s) if above else 0.0

    def compensate(self, rad_s: float) -> float:
        """Return the command, in rad/s, for which the wheel turns at a velocity: the inverse of `respond`.

        rad_s: the velocity of the wheel in rad/s. The command for 0 is 0.
        """
        if not rad_s:
            return 0.0
        above = abs(rad_s) / self._select_gain(rad_s) * self._linear_share
        return math.copysign(self.dead_band_rad_s + above, rad_s)

    def raise_max_velocity(self, max_velocity_rad_s: float) -> MotorDescription:
        """Return the description of a motor that responds in the same way, but also to greater commands.

        max_velocity_rad_s: the greatest velocity of the motor, in rad/s. A smaller one than now changes nothing.
        """
        if max_velocity_rad_s <= self.max_velocity_rad_s:
            return self
        wider = self.model_copy(update={"max_velocity_rad_s": max_velocity_rad_s})
        scale = wider._linear_share / self._linear_share  # noqa: SLF001  its own kind
        gains = {"forward_gain": self.forward_gain * scale, "backward_gain": self.backward_gain * scale}
        return wider.model_copy(update=gains)

    @property
    def is_exact(self) -> bool:
        """Whether the wheel turns at the commanded velocity, apart from the lag."""
        return not self.dead_band_rad_s and self.forward_gain == self.backward_gain == 1.0

    @property
    def max_wheel_velocity_rad_s(self) -> float:
        """The greatest velocity that the wheel reaches in both directions, in rad/s."""
        return self.max_velocity_rad_s * min(self.forward_gain, self.backward_gain)

    @property
    def _linear_share(self) -> float:
        return 1 - self.dead_band_rad_s / self.max_velocity_rad_s

    def _select_gain(self, direction: float) -> float:
        return self.forward_gain if direction > 0 else self.backward_gain


class Motor(Actuator[float], ABC):
    """A motor of a wheel. Its velocity is that of the wheel, positive forward on the left and on the right.

    An app drives by ``robot.drive``, which commands the motors of the drive. It commands other motors by
    `set_velocity`.

    name: the name of the motor, as in the robot's file.
    max_velocity: the greatest velocity in rad/s, forward and backward.

    >>> from robotcore.hal.kind import build_actuator
    >>> from robotcore.kinds.motor import MotorDescription
    >>> sent = []
    >>> arm = build_actuator(MotorDescription(kind="motor", name="arm", max_velocity_rad_s=10.0), sent.append)
    >>> arm.set_velocity(3.0), arm.set_velocity(99.0)  # rad/s; a greater velocity is limited
    (3.0, 10.0)
    >>> arm.close()  # a motor stops before it is closed
    >>> sent[:3]
    [3.0, 10.0, 0.0]
    """

    kind = "motor"
    command_unit = "rad/s"
    safe_command = 0.0

    def __init__(self, name: str, max_velocity: float) -> None:
        super().__init__(name)
        self.max_velocity = max_velocity

    def set_velocity(self, rad_s: float) -> float:
        """Send a velocity in rad/s, limited to ``max_velocity``, and return the velocity that was sent.

        It does not wait for hardware.

        Stops the motor and raises InvalidCommandError if ``rad_s`` is NaN or infinite. Raises DeviceError if the motor
        fails.
        """
        return self.send(rad_s)

    def _limit(self, command: float) -> float:
        if not math.isfinite(command):
            self.stop()
            raise invalid_velocity(self.name, command)
        return max(-self.max_velocity, min(command, self.max_velocity))


class VelocityOutput(Protocol):
    """The methods of a motor that layers of a run, such as a fault, can replace."""

    @property
    def name(self) -> str:
        """The motor's name."""

    def set_velocity(self, rad_s: float, /) -> float:
        """Send a velocity in rad/s, and return the velocity that was sent."""

    def stop(self) -> None:
        """Stop the motor."""


def invalid_velocity(name: str, rad_s: float) -> InvalidCommandError:
    """Return the error for a command that is NaN or infinite. Its message names the app's line that gave the command.

    name: the name of the motor.
    rad_s: the commanded velocity.
    """
    return build_invalid_command(name, f"a velocity of {rad_s} rad/s", ", and all motors were stopped")


KIND = Kind("a motor of a wheel", MotorDescription, Motor, test_devices=test_motors)
"""The kind `motor`, which the entry point of this name refers to."""

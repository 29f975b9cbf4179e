"""Velocity control of a wheel by its encoder, with feed-forward by the motor's model and a PI controller."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from threading import RLock
from typing import Annotated

from pydantic import Field, NonNegativeFloat

from robotcore.description import EncoderDescription, MotorDescription, RobotDescription, StrictModel
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import Clock, PeriodicTask
from robotcore.hal.devices import Encoder, Motor
from robotcore.hardware.driver import Host
from robotcore.hardware.motor_model import DutyMotor, MotorModel, Output
from robotcore.hardware.opening import encoder_of

ENOUGH_COUNTS = 8
"""A velocity is measured over at least this many counts. One count more or less then changes it by an eighth."""

LONGEST_S = 0.2
"""The longest time over which a velocity is measured, in seconds. An older velocity is useless for control."""


class Control(StrictModel):
    """The gains and the period of a wheel's PI controller."""

    kp: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """The proportional gain, in rad/s for each rad/s of error. With a gain below 1, a wheel that behaves like its model
    does not oscillate, even if the encoder's samples are late."""
    ki: NonNegativeFloat = 4.0
    """The integral gain, in rad/s for each radian of error. The control corrects an error of the model in about 2 /
    ``ki`` seconds."""
    period_s: Annotated[float, Field(ge=0.005, le=0.1)] = 0.02
    """The period of reading the encoder, in seconds."""


class VelocityControl:
    """Corrects the velocity that is sent to a motor, so that the wheel turns at the commanded velocity.

    The error is the difference from an expected angle, which follows the command with the motor's lag. So a wheel that
    only lags is not corrected. The integral part uses the error of the angle in whole encoder counts. The proportional
    part uses the mean error of the velocity over `ENOUGH_COUNTS` counts, and at most over `LONGEST_S` seconds.

    The velocity to send never has the opposite sign of the command. Its limit is twice the command, or the command plus
    a quarter of full speed, whichever is larger. That is enough to free a wheel that is stuck, and limits the wheel's
    speed when it comes free. The integral stays within these limits (anti-windup).
    """

    def __init__(self, gains: Control, model: MotorModel, lag: float, counts_per_turn: int) -> None:
        """Create the control of a wheel that stands.

        lag: the time constant of the motor in seconds.
        counts_per_turn: the encoder's counts in a turn of the wheel.
        """
        self._gains, self._model, self._lag = gains, model, lag
        self._enough_rad = ENOUGH_COUNTS * math.tau / counts_per_turn
        self._expected = 0.0
        self._integral = 0.0
        self._slips: deque[tuple[float, float]] = deque(maxlen=math.ceil(LONGEST_S / gains.period_s))
        self._at: tuple[float, float] | None = None

    def restart(self) -> None:
        """Clear the integral and the errors, after the wheel was stopped or reversed."""
        self._integral = 0.0
        self._slips.clear()

    def start(self, target: float) -> float:
        """Return the velocity in rad/s to send for a new command, before the next sample of the encoder.

        target: the commanded velocity in rad/s.
        """
        return self._limit(target, target + self._integral)

    def update(self, target: float, angle: float, time: float) -> float:
        """Return the velocity in rad/s to send after a new sample of the encoder.

        target: the commanded velocity in rad/s.
        angle: the angle of the wheel in rad.
        time: the time of the sample in seconds.
        """
        last, self._at = self._at, (angle, time)
        if last is None or (passed := time - last[1]) <= 0:
            return self.start(target)
        slip = self._turn_expected(target, passed) - (angle - last[0])
        if not target:
            return 0.0
        self._slips.append((slip, passed))
        self._integral = self._limit(target, target + self._integral + self._gains.ki * slip) - target
        return self._limit(target, target + self._integral + self._gains.kp * self._mean_slip(target))

    def _turn_expected(self, target: float, passed: float) -> float:
        """Return the angle in rad by which a wheel with the motor's first-order lag turns in ``passed`` seconds."""
        before = self._expected
        self._expected = target + (before - target) * (math.exp(-passed / self._lag) if self._lag else 0.0)
        return target * passed + (before - self._expected) * self._lag

    def _mean_slip(self, target: float) -> float:
        """Return the mean error of the velocity in rad/s, positive if the wheel is too slow."""
        behind = taken = 0.0
        for slip, passed in reversed(self._slips):
            behind, taken = behind + slip, taken + passed
            if taken * abs(target) >= self._enough_rad:
                break
        return behind / taken

    def _limit(self, target: float, velocity: float) -> float:
        direction = math.copysign(1, target)
        reach = self._model.reach(direction)
        most = min(abs(target) + max(abs(target), reach / 4), reach)
        return direction * min(max(direction * velocity, 0.0), most)


class ControlledMotor(DutyMotor):
    """A motor whose velocity is corrected by a `VelocityControl` after each sample of the wheel's encoder.

    Several threads may set commands, and a background task sends corrections. A lock ensures that no correction turns
    the wheel after a stop. If the encoder fails, the motor stops, and the next command other than a stop raises the
    failure. If the encoder was lost, this command first reads the encoder again, and raises nothing if that succeeds.
    """

    def __init__(
        self,
        description: MotorDescription,
        model: MotorModel,
        output: Output,
        control: VelocityControl,
        encoder: Encoder,
    ) -> None:
        super().__init__(description, model, output)
        self._control, self._encoder = control, encoder
        self._target = 0.0
        self._failure: DeviceError | None = None
        self._lock = RLock()
        self._polling: PeriodicTask | None = None

    def begin(self, clock: Clock, period: float) -> None:
        """Start the control: read the encoder now, and then every ``period`` seconds."""
        self._correct()
        self._polling = clock.every(period, self._correct, f"{self.name} control")

    def _apply(self, rad_s: float) -> None:
        with self._lock:
            if rad_s:
                self._require_encoder()
            if rad_s * self._target <= 0:
                self._control.restart()
            self._target = rad_s
            self._send(self._control.start(rad_s) if rad_s else 0.0)

    def _require_encoder(self) -> None:
        """Raise the failure of the encoder, if there is one.

        A loss of the encoder is raised until the encoder is back, any other failure only once.

        When the encoder is back, control continues from its angle, and does not correct turns during the loss.
        """
        if isinstance(self._failure, DeviceLostError):
            sample = self._encoder.read()
            self._control.update(self._target, sample.angle, sample.time)
            self._failure = None
        elif failure := self._failure:
            self._failure = None
            raise failure

    def _correct(self) -> None:
        try:
            sample = self._encoder.read()
            with self._lock:
                velocity = self._control.update(self._target, sample.angle, sample.time)
                if self._target:
                    self._send(velocity)
        except DeviceError as failure:
            self._fail(failure)

    def _fail(self, failure: DeviceError) -> None:
        with self._lock, suppress(DeviceError):  # the first failure is kept
            self._failure = self._failure or failure
            self._apply(0.0)

    def _release(self) -> None:
        if self._polling:
            self._polling.stop()
        super()._release()


def open_motor(
    description: MotorDescription, model: MotorModel, control: Control | None, output: Callable[[], Output], host: Host
) -> Motor:
    """Return an open motor on an output that takes duties.

    control: the settings of velocity control by the wheel's encoder. None means that the model alone gives the duty.
    output: opens the motor's output.
    Raises DeviceError if control needs an encoder that is not open.
    """
    if control is None:
        return DutyMotor(description, model, output())
    encoder, counts = _encoder_on(description.name, host)
    controller = VelocityControl(control, model, description.lag_s, counts)
    motor = ControlledMotor(description, model, output(), controller, encoder)
    motor.begin(host.clock, control.period_s)
    return motor


def require_drivable(
    description: MotorDescription, model: MotorModel, control: Control | None, robot: RobotDescription
) -> None:
    """Raise ValueError if these settings cannot drive a motor. The text is the problem, a semicolon and a remedy.

    That is so if the model does not reach the motor's maximum velocity, or ``control`` needs an encoder that is
    missing.
    """
    _require_reach(description, model)
    if control:
        _require_encoder(description.name, robot)


def _require_reach(description: MotorDescription, model: MotorModel) -> None:
    for direction, word in ((1, "forward"), (-1, "backward")):
        if (reach := model.reach(direction)) < description.max_velocity_rad_s:
            raise ValueError(
                f"by its model the wheel turns {word} at {reach:.3g} rad/s at most, but max_velocity_rad_s of "
                f"{description.name} is {description.max_velocity_rad_s:g}; lower it, or correct "
                f"model.{word}_rad_s or model.max_duty"
            )


def _require_encoder(motor: str, robot: RobotDescription) -> None:
    if encoder_of(motor, robot) is None:
        raise ValueError(
            f"control needs an encoder on the wheel of {motor}, which has none; name the encoders in [drive], or leave "
            "control out"
        )


def _encoder_on(motor: str, host: Host) -> tuple[Encoder, int]:
    """Return the open encoder on a motor's wheel, and its counts per turn; raises DeviceError if it is not open."""
    name = encoder_of(motor, host.robot)
    encoder = host.opened.get(name or "")
    if not isinstance(encoder, Encoder):
        raise DeviceError(
            motor,
            f"control needs the encoder {name!r}, which is not open. Open it too",
            kind="encoder-not-open",
            encoder=name,
        )
    return encoder, next(
        description.counts_per_turn for description in host.robot.all_of(EncoderDescription) if description.name == name
    )

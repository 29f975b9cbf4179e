"""Controls the velocity of a wheel by its encoder, with the motor's model as feed-forward and a PI controller."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from threading import RLock
from typing import Annotated

from pydantic import Field, NonNegativeFloat

from robotcore.description import RobotDescription, StrictModel
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import Clock, PeriodicTask
from robotcore.hardware.driver import DeviceContext
from robotcore.hardware.motor_model import DutyMotor, MotorModel, Output
from robotcore.hardware.opening import encoder_of
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription

MIN_COUNTS = 8
"""The least number of encoder counts from which a velocity is measured, for an error of at most 1/8."""

MAX_MEAN_S = 0.2
"""The longest time over which a velocity is measured, in seconds, even if it has fewer than `MIN_COUNTS` counts."""


class Control(StrictModel):
    """The gains and the period of a wheel's PI controller."""

    kp: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """The proportional gain, in rad/s for each rad/s of error. A gain below 1 avoids oscillation, even if the samples
    of the encoder are late."""
    ki: NonNegativeFloat = 4.0
    """The integral gain, in rad/s for each radian of error. An error of the model is corrected in about 2 / ``ki``
    seconds."""
    period_s: Annotated[float, Field(ge=0.005, le=0.1)] = 0.02
    """The period of the controller, in seconds. It reads the encoder once in each period."""


class VelocityControl:
    """A PI controller that corrects the velocity sent to a motor, so that the wheel turns at the commanded velocity.

    The expected angle of the wheel follows the command with the motor's lag. The error is the difference from this
    angle, so the lag itself is not corrected. The integral part uses the error of the angle. The proportional part uses
    the mean error of the velocity over `MIN_COUNTS` counts, but at most over `MAX_MEAN_S` seconds.

    The velocity to send never has the opposite sign of the command. Its limit is twice the command, or the command plus
    a quarter of full speed, whichever is larger. This limit frees a stuck wheel, but keeps the wheel slow when it comes
    free. The integral stays within the same limit (anti-windup).
    """

    def __init__(self, gains: Control, model: MotorModel, lag: float, counts_per_turn: int) -> None:
        """Create a controller for a wheel at rest.

        lag: the time constant of the motor's lag in seconds.
        counts_per_turn: the encoder's counts in a turn of the wheel.
        """
        self._gains, self._model, self._lag = gains, model, lag
        self._min_rad = MIN_COUNTS * math.tau / counts_per_turn
        self._expected = 0.0
        self._integral = 0.0
        self._errors: deque[tuple[float, float]] = deque(maxlen=math.ceil(MAX_MEAN_S / gains.period_s))
        self._last: tuple[float, float] | None = None

    def restart(self) -> None:
        """Clear the integral and the stored errors, for a new motion after a stop or a reversal."""
        self._integral = 0.0
        self._errors.clear()

    def start(self, target: float) -> float:
        """Return the velocity to send for a new command, in rad/s.

        target: the commanded velocity in rad/s.
        """
        return self._limit(target, target + self._integral)

    def update(self, target: float, angle: float, time: float) -> float:
        """Return the velocity to send after a new sample of the encoder, in rad/s.

        target: the commanded velocity in rad/s.
        angle: the angle of the wheel in radians.
        time: the time of the sample in seconds.
        """
        last, self._last = self._last, (angle, time)
        if last is None or (passed := time - last[1]) <= 0:
            return self.start(target)
        error = self._predict_turn(target, passed) - (angle - last[0])
        if not target:
            return 0.0
        self._errors.append((error, passed))
        self._integral = self._limit(target, target + self._integral + self._gains.ki * error) - target
        return self._limit(target, target + self._integral + self._gains.kp * self._mean_velocity_error(target))

    def _predict_turn(self, target: float, passed: float) -> float:
        before = self._expected
        self._expected = target + (before - target) * (math.exp(-passed / self._lag) if self._lag else 0.0)
        return target * passed + (before - self._expected) * self._lag

    def _mean_velocity_error(self, target: float) -> float:
        angle_error = duration = 0.0
        for error, passed in reversed(self._errors):
            angle_error, duration = angle_error + error, duration + passed
            if duration * abs(target) >= self._min_rad:
                break
        return angle_error / duration

    def _limit(self, target: float, velocity: float) -> float:
        direction = math.copysign(1, target)
        reach = self._model.reach(direction)
        most = min(abs(target) + max(abs(target), reach / 4), reach)
        return direction * min(max(direction * velocity, 0.0), most)


class ControlledMotor(DutyMotor):
    """A motor whose velocity a `VelocityControl` corrects after each sample of the wheel's encoder.

    A periodic task reads the encoder and sends the corrections, while other threads set commands. A lock ensures that
    no correction turns the wheel after a stop.

    If the encoder fails, the motor stops, and the next command other than a stop raises the failure. If the encoder was
    lost, that command first reads the encoder again. It raises nothing if the encoder is back.
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
        """Start the controller, which reads the encoder now and then every ``period`` seconds."""
        self._correct()
        self._polling = clock.call_every(period, self._correct, f"{self.name} control")

    def _apply(self, rad_s: float) -> None:
        with self._lock:
            if rad_s:
                self._require_encoder()
            if rad_s * self._target <= 0:
                self._control.restart()
            self._target = rad_s
            self._send(self._control.start(rad_s) if rad_s else 0.0)

    def _require_encoder(self) -> None:
        # A lost encoder is read again. If it is back, the turns during the loss are not corrected. Other failures are
        # raised once.
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
    description: MotorDescription,
    model: MotorModel,
    control: Control | None,
    output: Callable[[], Output],
    context: DeviceContext,
) -> Motor:
    """Return an open motor that sends duties.

    control: the settings of the velocity control. With None, the duty follows from the model alone.
    output: the function that opens the motor's output.

    Raises DeviceError if velocity control needs an encoder that is not open.
    """
    if control is None:
        return DutyMotor(description, model, output())
    encoder, counts = _encoder_on(description.name, context)
    controller = VelocityControl(control, model, description.lag_s, counts)
    motor = ControlledMotor(description, model, output(), controller, encoder)
    motor.begin(context.clock, control.period_s)
    return motor


def require_drivable(
    description: MotorDescription, model: MotorModel, control: Control | None, robot: RobotDescription
) -> None:
    """Raise ValueError if the model does not reach the motor's maximum velocity, or if the control lacks an encoder.

    The text of the error is the problem, a semicolon and a remedy.
    """
    for direction, word in ((1, "forward"), (-1, "backward")):
        if (reach := model.reach(direction)) < description.max_velocity_rad_s:
            raise ValueError(
                f"by its model, {description.name} turns {word} at {reach:.3g} rad/s at most, but its "
                f"max_velocity_rad_s is {description.max_velocity_rad_s:g}; reduce max_velocity_rad_s, or correct "
                f"model.{word}_rad_s or model.max_duty"
            )
    if control and encoder_of(description.name, robot) is None:
        raise ValueError(
            f"control needs an encoder, but the wheel of {description.name} has none; name the encoders in [drive], or "
            "remove control"
        )


def _encoder_on(motor: str, context: DeviceContext) -> tuple[Encoder, int]:
    """Return the open encoder on a motor's wheel, and the encoder's counts per turn."""
    name = encoder_of(motor, context.robot)
    encoder = context.opened.get(name or "")
    if not isinstance(encoder, Encoder):
        raise DeviceError(
            motor,
            f"control needs the encoder {name!r}, which is not open. Open the encoder too",
            kind="encoder-not-open",
            encoder=name,
        )
    return encoder, next(
        description.counts_per_turn
        for description in context.robot.all_of(EncoderDescription)
        if description.name == name
    )

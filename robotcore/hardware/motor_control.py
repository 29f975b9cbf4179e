"""A wheel's velocity, controlled by its encoder: the motor's model does most of it, a PI controller the rest."""

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
"""So many make a velocity worth the name: one more or less is an eighth of it."""

LONGEST_S = 0.2
"""A velocity that is measured for longer is too old to be controlled by."""


class Control(StrictModel):
    """The gains of a PI controller, and how often it looks at the encoder.

    ``kp`` is in rad/s for each rad/s that the wheel is too slow: below 1 it alone makes no wheel oscillate that is as
    its model says, however late the encoder tells. ``ki`` is in rad/s for each radian that the wheel is behind: what
    the model is wrong by is made up for within some 2 / ``ki`` seconds.
    """

    kp: Annotated[float, Field(ge=0, lt=1)] = 0.5
    ki: NonNegativeFloat = 4.0
    period_s: Annotated[float, Field(ge=0.005, le=0.1)] = 0.02


class VelocityControl:
    """Tells which velocity to send, by the motor's model, so that the wheel turns at the one asked for.

    What the wheel should have turned follows the command with the lag that the robot's description gives the motor: a
    wheel that only lags as it should is not corrected. The integral counts the angle by which it fell behind, in whole
    counts of the encoder, so that no velocity has to be made of few of them; the proportional part takes the mean
    over as many periods as `ENOUGH_COUNTS` take at the velocity asked for, though over no more than `LONGEST_S`.

    The output never reverses the command. It is limited to twice the command, or the command plus a quarter of full
    speed, whichever is larger: that frees a wheel that sticks, and one that comes free does not shoot off. The
    integral stays within these limits (anti-windup).
    """

    def __init__(self, gains: Control, model: MotorModel, lag: float, counts_per_turn: int) -> None:
        self._gains, self._model, self._lag = gains, model, lag
        self._enough_rad = ENOUGH_COUNTS * math.tau / counts_per_turn
        self._expected = 0.0
        self._integral = 0.0
        self._slips: deque[tuple[float, float]] = deque(maxlen=math.ceil(LONGEST_S / gains.period_s))
        self._at: tuple[float, float] | None = None

    def restart(self) -> None:
        """Forget what was corrected: the wheel was stopped, or told to turn the other way."""
        self._integral = 0.0
        self._slips.clear()

    def sent(self, asked: float) -> float:
        """Return the velocity to send for a new command, before the encoder has told of it."""
        return self._bounded(asked, asked + self._integral)

    def corrected(self, asked: float, angle: float, time: float) -> float:
        """Return the velocity to send now that the wheel was at ``angle`` (rad) at ``time`` (s)."""
        last, self._at = self._at, (angle, time)
        if last is None or (passed := time - last[1]) <= 0:
            return self.sent(asked)
        slip = self._turn_expected(asked, passed) - (angle - last[0])
        if not asked:
            return 0.0
        self._slips.append((slip, passed))
        self._integral = self._bounded(asked, asked + self._integral + self._gains.ki * slip) - asked
        return self._bounded(asked, asked + self._integral + self._gains.kp * self._mean_slip(asked))

    def _turn_expected(self, asked: float, passed: float) -> float:
        """Return by how much a wheel with a first-order lag turns on, in rad."""
        before = self._expected
        self._expected = asked + (before - asked) * (math.exp(-passed / self._lag) if self._lag else 0.0)
        return asked * passed + (before - self._expected) * self._lag

    def _mean_slip(self, asked: float) -> float:
        """Return by how many rad/s the wheel is too slow."""
        behind = taken = 0.0
        for slip, passed in reversed(self._slips):
            behind, taken = behind + slip, taken + passed
            if taken * abs(asked) >= self._enough_rad:
                break
        return behind / taken

    def _bounded(self, asked: float, velocity: float) -> float:
        direction = math.copysign(1, asked)
        reach = self._model.reach(direction)
        most = min(abs(asked) + max(abs(asked), reach / 4), reach)
        return direction * min(max(direction * velocity, 0.0), most)


class ControlledMotor(DutyMotor):
    """Sends what a controller makes of each command and, between commands, of what the encoder tells.

    Commands may come from several threads, and corrections come from one more: what is asked for and what is sent for
    it belong together by a lock that is only held while a command is handed on: nothing turns the wheel after a stop.
    Where the encoder fails the motor stops, and the next command that would turn it raises why. One that was lost is
    looked at again then: where it is back, nothing is raised.
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
        self._asked = 0.0
        self._failure: DeviceError | None = None
        self._lock = RLock()
        self._polling: PeriodicTask | None = None

    def begin(self, clock: Clock, period: float) -> None:
        """Look at the encoder now, and every ``period`` seconds from now on."""
        self._correct()
        self._polling = clock.every(period, self._correct, f"{self.name} control")

    def _apply(self, rad_s: float) -> None:
        with self._lock:
            if rad_s:
                self._require_encoder()
            if rad_s * self._asked <= 0:
                self._control.restart()
            self._asked = rad_s
            self._send(self._control.sent(rad_s) if rad_s else 0.0)

    def _require_encoder(self) -> None:
        """Raise why the encoder has failed, once; of one that was lost, for as long as it is.

        One that is back is gone on from: what the wheel did not turn meanwhile is not made up for.
        """
        if isinstance(self._failure, DeviceLostError):
            sample = self._encoder.read()
            self._control.corrected(self._asked, sample.angle, sample.time)
            self._failure = None
        elif failure := self._failure:
            self._failure = None
            raise failure

    def _correct(self) -> None:
        try:
            sample = self._encoder.read()
            with self._lock:
                velocity = self._control.corrected(self._asked, sample.angle, sample.time)
                if self._asked:
                    self._send(velocity)
        except DeviceError as failure:
            self._fail(failure)

    def _fail(self, failure: DeviceError) -> None:
        with self._lock, suppress(DeviceError):  # the first failure says why
            self._failure = self._failure or failure
            self._apply(0.0)

    def _release(self) -> None:
        if self._polling:
            self._polling.stop()
        super()._release()


def open_motor(
    description: MotorDescription, model: MotorModel, control: Control | None, output: Callable[[], Output], host: Host
) -> Motor:
    """Return a motor on the ``output`` that is opened for it, held by its wheel's encoder where there is ``control``.

    Raises DeviceError where that encoder is not open.
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
    """Raise ValueError, the fault, a semicolon and the remedy, where a motor cannot be driven so by duties.

    By its model the wheel cannot turn so fast, or it has no encoder by which it could be controlled.
    """
    _require_reach(description, model)
    if control:
        _require_encoder(description.name, robot)


def _require_reach(description: MotorDescription, model: MotorModel) -> None:
    for direction, word in ((1, "forward"), (-1, "backward")):
        if (reach := model.reach(direction)) < description.max_velocity_rad_s:
            raise ValueError(
                f"by its model the wheel turns {word} at {reach:.3g} rad/s at most, and max_velocity_rad_s of "
                f"{description.name} is {description.max_velocity_rad_s:g}; lower that, or correct "
                f"model.{word}_rad_s or model.max_duty"
            )


def _require_encoder(motor: str, robot: RobotDescription) -> None:
    if encoder_of(motor, robot) is None:
        raise ValueError(
            f"the wheel of {motor} has no encoder to be controlled by; name the encoders in [drive], or leave control "
            "out"
        )


def _encoder_on(motor: str, host: Host) -> tuple[Encoder, int]:
    """Return the open encoder on a motor's wheel, and its counts per turn; raises DeviceError."""
    name = encoder_of(motor, host.robot)
    encoder = host.opened.get(name or "")
    if not isinstance(encoder, Encoder):
        raise DeviceError(
            motor,
            f"cannot be controlled without the encoder {name!r}, which is not open. Open it too",
            kind="encoder-not-open",
            encoder=name,
        )
    return encoder, next(
        description.counts_per_turn for description in host.robot.all_of(EncoderDescription) if description.name == name
    )

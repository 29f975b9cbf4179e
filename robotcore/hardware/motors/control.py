"""Holding a wheel's velocity by its encoder: the motor's model does most of it, a PI controller the rest."""

from __future__ import annotations

import math
from collections import deque
from typing import Annotated

from pydantic import Field, NonNegativeFloat

from robotcore.description import Described
from robotcore.hardware.motors.model import MotorModel

ENOUGH_COUNTS = 8
"""So many make a velocity worth the name: one more or less is an eighth of it."""

LONGEST_S = 0.2
"""A velocity that is measured for longer is too old to be controlled by."""


class Control(Described):
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

    The velocity to send never turns against the command. It is at most twice the one asked for, though a quarter of
    what the motor reaches may always be added, for a wheel that sticks: one that was blocked and comes free does not
    shoot off. The integral stays within what can be sent beside the command (anti-windup).
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

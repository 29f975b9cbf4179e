"""From two wheels to the steer and speed that the board's mixer makes these wheels of."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

from drivers.serial.boards.hoverboard.protocol import LIMIT

ONE = 1 << 14
"""1.0 as the firmware keeps its coefficients."""


class Steering(NamedTuple):
    """The two words of a command."""

    steer: int
    speed: int


class Mixer(ABC):
    """What a board makes of steer and speed; wheels are in its own unit, from -1000 to 1000, positive forward."""

    @property
    @abstractmethod
    def straight(self) -> float:
        """The most that both wheels reach alike."""

    @property
    @abstractmethod
    def turning(self) -> float:
        """The most that the wheels reach against each other, on the spot."""

    @abstractmethod
    def steering(self, left: float, right: float) -> Steering:
        """Return the command for these wheels; of more than it can do, both have the same part: the path stays."""


class Tank(Mixer):
    """The board mixes nothing (TANK_STEERING): steer is the left wheel, speed the right one.

    >>> Tank().steering(-2000, 1000)
    Steering(steer=-1000, speed=500)
    """

    straight = turning = float(LIMIT)

    def __str__(self) -> str:
        return "tank steering"

    def steering(self, left: float, right: float) -> Steering:
        part = _part(left, right)
        return Steering(round(left * part), round(right * part))


@dataclass(frozen=True)
class Mixed(Mixer):
    """Left is speed and steer, right is speed less steer, each by its coefficient.

    They are SPEED_COEFFICIENT and STEER_COEFFICIENT in the firmware's config.h, divided by 16384. Source: `mixerFcn` in
    its Src/util.c.

    >>> Mixed().steering(101, 100), Mixed().wheels(Steering(1, 101))
    (Steering(steer=1, speed=101), (101, 100))
    >>> Mixed().steering(-1000, 1000)
    Steering(steer=-1000, speed=0)
    """

    speed_coefficient: float = 1.0
    steer_coefficient: float = 0.5

    def __str__(self) -> str:
        return f"coefficients {self.speed_coefficient:g} and {self.steer_coefficient:g}"

    @property
    def straight(self) -> float:
        return LIMIT * min(self.speed_coefficient, 1.0)

    @property
    def turning(self) -> float:
        return LIMIT * min(abs(self.steer_coefficient), 1.0)

    def steering(self, left: float, right: float) -> Steering:
        part = _part(left, right)
        steer = (left - right) * part / 2 / self.steer_coefficient
        speed = (left + right) * part / 2 / self.speed_coefficient
        part *= (again := _part(steer, speed))
        near = product(_around(steer * again), _around(speed * again))
        return min(
            (Steering(*words) for words in near), key=lambda words: self._error(words, left * part, right * part)
        )

    def wheels(self, told: Steering) -> tuple[int, int]:
        """Return what the board makes of a command for the left and the right wheel, to the bit."""
        steer = told.steer * 16 * round(self.steer_coefficient * ONE) >> 14
        speed = told.speed * 16 * round(self.speed_coefficient * ONE) >> 14
        return _limited(speed + steer >> 4), _limited(speed - steer >> 4)

    def _error(self, told: Steering, left: float, right: float) -> float:
        made_left, made_right = self.wheels(told)
        return (made_left - left) ** 2 + (made_right - right) ** 2


def _part(*words: float) -> float:
    """Return how much of them there can be, so that none is beyond the limit."""
    return min(1.0, LIMIT / max(map(abs, (*words, 1.0))))


def _around(word: float) -> range:
    """Return the whole words next to it that a command can have, and one above: the board rounds down."""
    below = math.floor(word)
    return range(max(below, -LIMIT), min(below + 2, LIMIT) + 1)


def _limited(wheel: int) -> int:
    return max(-LIMIT, min(wheel, LIMIT))

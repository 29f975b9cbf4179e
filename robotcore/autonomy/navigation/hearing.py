"""What a robot hears, held against what it heard just before and after, and against what it had learnt."""

from __future__ import annotations

from typing import NamedTuple

from robotcore.autonomy.navigation.memory import Memory, Remembered
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.devices import RangeSensor

JUMP_M = 0.15
"""A reading that differs more than this from the one before is of something else, or of nothing."""

BACK_M = 0.05
"""Readings that differ less than this are of the same thing: a tick's way, and some noise."""

SURPRISES = 2
"""So many echoes of one thing in a row, from the midst of what was free, are no accident: the map is wrong."""


class Heard(NamedTuple):
    """A distance in metres, that of the sensor's range where nothing was heard, and from where."""

    distance: float
    sensor: Pose

    def differs(self, other: Heard, limit: float) -> bool:
        """Return whether the distances differ by more than ``limit``."""
        return abs(self.distance - other.distance) > limit

    def overlaps(self, other: Heard, cone: float) -> bool:
        """Return whether what was in the cone at any time between the two was in it at one of them."""
        return abs(wrap_angle(self.sensor.heading - other.sensor.heading)) <= cone / 2


class Doubt(NamedTuple):
    """What was heard, and remembered, before a reading that jumped."""

    heard: Heard
    remembered: Remembered


class Hearing:
    """Takes readings into a memory.

    A reading that jumps, after which the next is again like the one before it, was a false echo, or a lost one, where
    the cone has not turned on meanwhile: what was learnt of it is taken back. Echoes of one thing from the midst of
    what was free, one after the other, say that the robot is not where its wheels have it, or that things have moved:
    then all but what was learnt lately is forgotten.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._last: Heard | None = None
        self._doubt: Doubt | None = None
        self._surprises = 0

    def hear(self, sensor: RangeSensor, distance: float, at: Pose) -> bool:
        """Take in what ``sensor`` read when the robot was ``at`` a pose; return whether that made the memory forget."""
        heard = Heard(min(distance, sensor.max_range), at.moved(sensor.mount))
        self._settle(heard, sensor.cone)
        if self._last and heard.differs(self._last, JUMP_M):
            self._doubt = Doubt(self._last, self._memory.remembered())
            self._surprises = 0
        self._last = heard
        is_forgotten = self._refutes(heard, sensor.cone, is_echo=distance <= sensor.max_range)
        self._memory.grid.add_range(heard.sensor, distance, sensor.max_range, sensor.cone)
        return is_forgotten

    def _settle(self, heard: Heard, cone: float) -> None:
        """Take back what was doubted where this reading contradicts it; else believe it."""
        doubt, self._doubt = self._doubt, None
        if doubt and heard.overlaps(doubt.heard, cone) and not heard.differs(doubt.heard, BACK_M):
            self._memory.restore(doubt.remembered)
            self._last = doubt.heard

    def _refutes(self, heard: Heard, cone: float, *, is_echo: bool) -> bool:
        """Forget where echoes refute what was learnt; of what is about this one, all."""
        grid = self._memory.grid
        is_surprise = is_echo and grid.is_refuted_by(heard.sensor, heard.distance, cone)
        self._surprises = self._surprises + 1 if is_surprise else 0
        if self._surprises < SURPRISES:
            return False
        self._memory.forget_old()
        grid.forget_about(heard.sensor, heard.distance, cone)
        return True

"""The pace of simulated time: its speed, pauses and single ticks."""

from __future__ import annotations

import math
from collections.abc import Callable
from numbers import Real
from threading import Lock

from robotcore.errors import UsageError
from robotcore.hal.wall_clock import MonotonicClock

__all__ = ["PaceControl"]

POLL_S = 0.02
"""The interval at which a waiting loop checks the speed, the steps, the signals and the e-stop, in seconds."""


class PaceControl:
    """Sets the pace of simulated time. Any thread may call `pause`, `resume` and `step`, and set ``speed``.

    The loop waits only between two ticks, so that a run has the same trace at each pace. While it waits, a signal or
    the e-stop still ends the run.

    speed: the ratio of simulated time to real time (the real-time factor). ``math.inf`` is as fast as possible.

    Raises UsageError if ``speed`` is not a positive number.

    >>> pace = PaceControl()
    >>> pace.speed = 2.5
    >>> pace.pause()
    >>> pace
    PaceControl(speed=2.5, paused)
    """

    def __init__(self, speed: float = 1.0) -> None:
        self._wall = MonotonicClock()
        self._start: tuple[float, float] | None = None
        """The real and the simulated time from which the present speed holds. None until the next tick."""
        self._is_paused = False
        self._steps = 0
        self._lock = Lock()
        self._speed = 1.0
        self.speed = speed

    def __repr__(self) -> str:
        return f"PaceControl(speed={self._speed:g}{', paused' if self._is_paused else ''})"

    @property
    def speed(self) -> float:
        """The ratio of simulated time to real time. A slow machine does not reach a high speed."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if not (isinstance(speed, Real) and speed > 0):
            raise UsageError(
                f"the speed is {speed!r}; it must be a positive number, or math.inf. To let no time pass, call pause()",
                kind="speed-not-positive",
                speed=speed,
            )
        if speed != self._speed:
            self._speed = float(speed)
            self._start = None

    @property
    def is_paused(self) -> bool:
        """Whether the loop waits before each tick until `step` or `resume`."""
        return self._is_paused

    def pause(self) -> None:
        """Let the loop wait before the next tick."""
        self._is_paused = True

    def resume(self) -> None:
        """End the pause. Without a pause, this does nothing."""
        with self._lock:
            self._is_paused, self._steps = False, 0

    def step(self, ticks: int = 1) -> None:
        """Let the paused loop run ``ticks`` more ticks. Raises UsageError without a pause."""
        with self._lock:
            if not self._is_paused:
                raise UsageError("the run is not paused. Call pause() before step()", kind="not-paused")
            if not isinstance(ticks, int) or ticks < 1:
                text = f"step has {ticks!r:.100} ticks; it must have a whole number of at least 1"
                raise UsageError(text, kind="no-ticks", ticks=ticks)
            self._steps += ticks

    def keep_speed(self, time: float, check: Callable[[], object]) -> bool:
        """Wait until the simulated time may be ``time``, in seconds. Return False if the machine is too slow.

        The loop calls this after each tick. A speed above 1 is a limit, so no machine is too slow for it.

        check: a function that is called while this waits, and raises an exception to end the wait.
        """
        if self._speed == math.inf:
            return True
        has_waited = False
        while (start := self._start) and not self._is_paused:  # another thread may set it to None
            real, simulated = start
            now = self._wall.now()
            if (left := real + (time - simulated) / self._speed - now) <= 0:
                if left == 0 or has_waited:
                    return True
                self._start = now, time
                return self._speed > 1
            self._wall.sleep_until(now + min(left, POLL_S))
            has_waited = True
            check()
        self._start = self._wall.now(), time
        return True

    def hold(self, time: float, check: Callable[[], object]) -> None:
        """Wait while the run is paused. The loop calls this before each tick.

        time: the simulated time in seconds.
        check: a function that is called while this waits, and raises an exception to end the wait.
        """
        while self._is_paused and not self._take_step():
            self._wall.sleep_until(self._wall.now() + POLL_S)
            check()
            self._start = self._wall.now(), time

    def restart(self, time: float) -> None:
        """Count no real time from the last tick until now. ``time`` is the simulated time in seconds."""
        self._start = self._wall.now(), time

    def _take_step(self) -> bool:
        with self._lock:
            if self._steps:
                self._steps -= 1
                return True
            return False

"""Stops motors, each independently of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from threading import get_ident
from typing import TypeVar

from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.motor import VelocityOutput
from robotcore.safety.thread_reserve import BackgroundCall, Reserve
from robotcore.threads import is_out_of_memory

T = TypeVar("T")

STOP_S = 0.2
"""The longest wait for the stop of a motor, in seconds. A longer stop goes on in its thread."""


class MotorStop:
    """Stops one motor. At most one stop of the motor runs at a time."""

    def __init__(self, motor: VelocityOutput, reserve: Reserve) -> None:
        self.motor = motor
        self._reserve = reserve
        self._under_way: BackgroundCall | None = None

    @property
    def is_hung(self) -> bool:
        """Whether a stop has begun and not returned."""
        return self._under_way is not None and self._under_way.is_under_way

    def apply(self) -> None:
        """Stop the motor in this thread. Wait first for a stop in another thread.

        Raises DeviceError if the other stop hangs.
        """
        if self._under_way and not self._under_way.is_done_within(STOP_S):
            raise self._build_hang_error()
        self._stop()

    def begin(self, within_s: float = STOP_S) -> Callable[[], Exception | None]:
        """Begin to stop the motor in a reserved thread. Return a function that waits for the end of the stop.

        The function waits at most ``within_s`` seconds. It returns the exception of the stop, or None.
        """
        call = self._under_way
        if call is None or not call.is_under_way:
            self._under_way = call = self._reserve.retry_on_memory_error(lambda: self._reserve.call(self._stop))
        return lambda: self._get_failure(call) if call.is_done_within(within_s) else self._build_hang_error(within_s)

    def _stop(self) -> None:
        self._reserve.retry_on_memory_error(self.motor.stop)

    def _get_failure(self, call: BackgroundCall) -> Exception | None:
        # A stop that ran out of memory is repeated in this thread.
        failure = call.failure
        if failure and is_out_of_memory(failure):
            try:
                self._stop()
            except Exception as again:  # noqa: BLE001  the exception is returned
                return again
            return None
        if failure is None or isinstance(failure, Exception):
            return failure
        return DeviceError(self.motor.name, f"its stop raised {type(failure).__name__}", kind="stop-raised")

    def _build_hang_error(self, within_s: float = STOP_S) -> DeviceError:
        return DeviceError(
            self.motor.name,
            f"has not stopped within {within_s:g} s. If it still turns, cut its power",
            kind="stop-timeout",
            within_s=within_s,
        )


class StopGroup:
    """Stops motors, each independently of the others.

    The thread that created the group stops the motors one after the other, because the watchdog supervises it. Any
    other thread stops each motor in a reserved thread, so that a motor that hangs does not delay the others. Without an
    idle reserved thread, it stops the motors one after the other.
    """

    def __init__(self, stops: Iterable[MotorStop], reserve: Reserve) -> None:
        self.reserve = reserve
        self._stops = tuple(stops)
        self._owner = get_ident()

    def __repr__(self) -> str:
        hung = [stop.motor.name for stop in self._stops if stop.is_hung]
        return f"StopGroup({', '.join(stop.motor.name for stop in self._stops)}; hung: {', '.join(hung) or 'none'})"

    @classmethod
    def create(cls, *motors: VelocityOutput, reserve: Reserve | None = None) -> StopGroup:
        """Return a group that stops these motors."""
        reserve = reserve or Reserve(MonotonicClock())
        return cls([MotorStop(motor, reserve) for motor in motors], reserve)

    def select(self, *motors: VelocityOutput) -> StopGroup:
        """Return a group that stops some of the motors of this group."""
        return StopGroup([stop for stop in self._stops if stop.motor in motors], self.reserve)

    @property
    def are_hung(self) -> bool:
        """Whether the stop of any motor has begun and not returned."""
        return any(stop.is_hung for stop in self._stops)

    def apply(self) -> None:
        """Stop every motor, then raise the first exception.

        DeviceLostError is raised only if there is no other exception.
        """
        failures: list[Exception] = []
        if get_ident() == self._owner:
            _try_all([stop.apply for stop in self._stops], failures)
        else:
            failures = self.apply_apart()
        if failures:
            raise min(failures, key=lambda failure: isinstance(failure, DeviceLostError))

    def apply_apart(self, within_s: float = STOP_S) -> list[Exception]:
        """Stop each motor in a reserved thread. Return the exceptions after at most ``within_s`` seconds."""
        failures: list[Exception] = []
        waits = _try_all([partial(stop.begin, within_s) for stop in self._stops], failures)
        return failures + [failure for wait in waits if (failure := wait())]


def _try_all(tries: Iterable[Callable[[], T]], failures: list[Exception]) -> list[T]:
    results = []
    for attempt in tries:
        try:
            results.append(attempt())
        except Exception as failure:  # noqa: BLE001, PERF203  one failure must not prevent the other stops
            failures.append(failure)
    return results

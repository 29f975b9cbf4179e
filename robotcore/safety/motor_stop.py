"""Stops motors, each independently of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from threading import get_ident
from typing import TypeVar

from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.devices import Motor
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.reserve import BackgroundCall, Reserve
from robotcore.threads import is_out_of_memory

T = TypeVar("T")

STOP_S = 0.2
"""A motor whose stop takes longer is given up, though its stop goes on: nothing waits for it again."""


class MotorStop:
    """Stops one motor. While one stop is under way no other is begun."""

    def __init__(self, motor: Motor, reserve: Reserve) -> None:
        self.motor = motor
        self._reserve = reserve
        self._under_way: BackgroundCall | None = None

    @property
    def is_hung(self) -> bool:
        """Whether a stop that was begun has not come back."""
        return self._under_way is not None and self._under_way.is_under_way

    def apply(self) -> None:
        """Stop the motor here and now, after a stop that is under way, unless that hangs."""
        if self._under_way and not self._under_way.is_done_within(STOP_S):
            raise self._hung()
        self._stop()

    def begin(self, within_s: float = STOP_S) -> Callable[[], Exception | None]:
        """Stop the motor in a thread of the reserve; return a function that waits so long, and returns the failure."""
        call = self._under_way
        if call is None or not call.is_under_way:
            self._under_way = call = self._reserve.retry_on_memory_error(self._call)
        return lambda: self._failure_of(call) if call.is_done_within(within_s) else self._hung(within_s)

    def _call(self) -> BackgroundCall:
        return self._reserve.call(self._stop)

    def _stop(self) -> None:
        self._reserve.retry_on_memory_error(self.motor.stop)

    def _failure_of(self, call: BackgroundCall) -> Exception | None:
        """Return why a stop failed; one that ran out of memory is made again, in place."""
        failure = call.failure
        if failure and is_out_of_memory(failure):
            try:
                self._stop()
            except Exception as again:  # noqa: BLE001  the caller asks for it
                return again
            return None
        if failure is None or isinstance(failure, Exception):
            return failure
        return DeviceError(self.motor.name, f"its stop raised {type(failure).__name__}")

    def _hung(self, within_s: float = STOP_S) -> DeviceError:
        return DeviceError(
            self.motor.name, f"has not stopped within {within_s:g} s; cut its power where it still turns"
        )


class StopGroup:
    """Stops motors, each on its own.

    The thread that made this stops them one after the other: the watchdog looks after it. From any other thread each is
    stopped in a thread of the ``reserve``, so that one that hangs does not hold up the others. Without threads in the
    reserve they are stopped one after the other.
    """

    def __init__(self, brakes: Iterable[MotorStop], reserve: Reserve) -> None:
        self.reserve = reserve
        self._brakes = tuple(brakes)
        self._home = get_ident()

    @classmethod
    def on(cls, *motors: Motor, reserve: Reserve | None = None) -> StopGroup:
        """Return brakes for these motors."""
        reserve = reserve or Reserve(MonotonicClock())
        return cls([MotorStop(motor, reserve) for motor in motors], reserve)

    def of(self, *motors: Motor) -> StopGroup:
        """Return the same brakes for some of the motors alone."""
        return StopGroup([brake for brake in self._brakes if brake.motor in motors], self.reserve)

    @property
    def are_hung(self) -> bool:
        """Whether a stop has not come back."""
        return any(brake.is_hung for brake in self._brakes)

    def apply(self) -> None:
        """Stop every motor; raise the first failure when all were tried, before one that is lost one that is there."""
        failures = self._in_turn() if get_ident() == self._home else self.apply_apart()
        if failures:
            raise min(failures, key=lambda failure: isinstance(failure, DeviceLostError))

    def apply_apart(self, within_s: float = STOP_S) -> list[Exception]:
        """Stop every motor in a thread of the reserve; return what failed, within that time."""
        failures: list[Exception] = []
        waits = _try_all([partial(brake.begin, within_s) for brake in self._brakes], failures)
        return failures + [failure for wait in waits if (failure := wait())]

    def _in_turn(self) -> list[Exception]:
        failures: list[Exception] = []
        _try_all([brake.apply for brake in self._brakes], failures)
        return failures


def _try_all(tries: Iterable[Callable[[], T]], failures: list[Exception]) -> list[T]:
    """Call every function. Return the results; append each exception to ``failures``."""
    results = []
    for attempt in tries:
        try:
            results.append(attempt())
        except Exception as failure:  # noqa: BLE001, PERF203  one that fails must not keep the others from stopping
            failures.append(failure)
    return results

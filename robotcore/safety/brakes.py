"""How motors are stopped: each on its own, whatever becomes of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from threading import get_ident

from robotcore.devices import Motor
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.safety.errand import Errand

STOP_S = 0.2
"""A motor whose stop takes longer is given up, though its stop goes on: nobody waits for it again."""


class Brake:
    """Stops one motor. While one stop is under way no other is begun."""

    def __init__(self, motor: Motor) -> None:
        self.motor = motor
        self._errand: Errand | None = None

    @property
    def is_hung(self) -> bool:
        """Whether a stop that was begun has not come back."""
        return self._errand is not None and self._errand.is_under_way

    def apply(self) -> None:
        """Stop the motor here and now, after a stop that is under way, unless that hangs."""
        if self._errand and not self._errand.is_done_within(STOP_S):
            raise self._hung()
        self.motor.stop()

    def begin(self, within_s: float = STOP_S) -> Callable[[], Exception | None]:
        """Stop the motor in a thread of its own; return what waits for that so long, and tells how it failed."""
        errand = self._errand
        if errand is None or not errand.is_under_way:
            self._errand = errand = Errand(f"stop {self.motor.name}", self.motor.stop)
        return lambda: errand.failure if errand.is_done_within(within_s) else self._hung(within_s)

    def _hung(self, within_s: float = STOP_S) -> DeviceError:
        return DeviceError(
            self.motor.name, f"has not stopped within {within_s:g} s; cut its power where it still turns"
        )


class Brakes:
    """Stops motors, each on its own.

    The thread that made this stops them one after the other: the watchdog looks after it. From any other thread each is
    stopped in a thread of its own, so that one that hangs does not hold up the others.
    """

    def __init__(self, brakes: Iterable[Brake]) -> None:
        self._brakes = tuple(brakes)
        self._home = get_ident()

    @classmethod
    def on(cls, *motors: Motor) -> Brakes:
        """Return brakes for these motors."""
        return cls(map(Brake, motors))

    def of(self, *motors: Motor) -> Brakes:
        """Return the same brakes for some of the motors alone."""
        return Brakes(brake for brake in self._brakes if brake.motor in motors)

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
        """Stop every motor in a thread of its own; return what failed, within that time."""
        failures = [failure_of() for failure_of in [brake.begin(within_s) for brake in self._brakes]]
        return [failure for failure in failures if failure]

    def _in_turn(self) -> list[Exception]:
        failures = []
        for brake in self._brakes:
            try:
                brake.apply()
            except Exception as failure:  # noqa: BLE001, PERF203  one that fails must not keep the others from stopping
                failures.append(failure)
        return failures

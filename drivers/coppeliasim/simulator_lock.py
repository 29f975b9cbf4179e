"""A lock that prevents two programs from driving one simulator at the same time.

A parameter of the running CoppeliaSim stores the lock. Scene files do not contain the parameter. The program that
holds the lock renews it periodically, so that the lock of a killed program expires.

CoppeliaSim drops a client that makes no calls. Each renewal is a call, so CoppeliaSim does not drop the program while
its app computes for long.
"""

from __future__ import annotations

import math
from contextlib import suppress
from uuid import uuid4

from drivers.coppeliasim.connection import SimulatorConnection
from robotcore.errors import BackendError
from robotcore.hal.clock import PeriodicTask
from robotcore.hal.wall_clock import MonotonicClock

PARAMETER = "robotcore.lease"
RENEWAL_S = 1.0
DEAD_S = 3.0
"""The time without a renewal after which a lock expires, in seconds."""

_POLL_S = 0.2


class SimulatorLock:
    """The exclusive right to drive a simulator, from `acquire` to `release`.

    connection: the connection to the simulator.
    """

    def __init__(self, connection: SimulatorConnection) -> None:
        self._connection = connection
        self._holder = uuid4().hex
        self._renewals = 0
        self._clock = MonotonicClock()
        self._renewal: PeriodicTask | None = None

    def acquire(self) -> bool:
        """Acquire the lock, and renew it periodically until `release`.

        Returns True if the previous holder has ended without a release. Raises BackendError if a running program holds
        the lock.
        """
        if note := self._read_note():
            self._await_expiry(note)
        self._write_note(f"{self._holder} 0")
        self._renewal = self._clock.call_every(RENEWAL_S, self._renew, "coppeliasim lease")
        return bool(note)

    def require_ownership(self) -> None:
        """Raise BackendError if the lock has expired and another program has acquired it.

        Each further call on the connection then raises the same error. Otherwise this program would stop the
        simulation of the other program, and remove its objects.
        """
        note = self._read_note()
        if note and not note.startswith(self._holder):
            lost = BackendError(
                f"coppeliasim: another program has taken over the CoppeliaSim at {self._connection.address}, because "
                f"this program was suspended or busy for more than {DEAD_S:g} s. Run again after that program has "
                "ended",
                kind="lease-lost",
                address=str(self._connection.address),
            )
            self._connection.fail(lost)
            raise lost

    def release(self) -> None:
        """Release the lock if this program holds it. If the simulator has ended, no error is raised."""
        if self._renewal is None:
            return
        self._renewal.stop()
        self._renewal = None
        with suppress(BackendError):
            self.require_ownership()
            self._write_note("")

    def _await_expiry(self, note: str) -> None:
        """Wait until the lock is released or has expired. Raises BackendError if its holder renews it.

        note: the present value of the parameter.

        The wait is a number of reads, not a time: a busy simulator delays the holder's renewals and these reads alike.
        """
        for _ in range(math.ceil(DEAD_S / _POLL_S)):
            self._clock.sleep_until(self._clock.now() + _POLL_S)
            current = self._read_note()
            if not current:
                return
            if current != note:
                raise BackendError(
                    f"coppeliasim: another program drives the CoppeliaSim at {self._connection.address}. Wait until "
                    "it ends, or start a second CoppeliaSim with another port",
                    kind="lease-held",
                    address=str(self._connection.address),
                )

    def _renew(self) -> None:
        self.require_ownership()
        self._renewals += 1
        self._write_note(f"{self._holder} {self._renewals}")

    def _read_note(self) -> str:
        note = self._connection.sim("getNamedStringParam", PARAMETER)
        return note.decode(errors="replace") if isinstance(note, bytes) else str(note or "")

    def _write_note(self, note: str) -> None:
        self._connection.sim("setNamedStringParam", PARAMETER, note)

"""The lease of a simulator, which prevents two programs from stepping one simulation.

The program that holds the lease renews it periodically. A parameter of the running CoppeliaSim stores the lease; scene
files do not contain it. CoppeliaSim drops clients that make no calls. A renewal is a call, so CoppeliaSim does not drop
the holder while its app computes for long.
"""

from __future__ import annotations

import math
from contextlib import suppress
from uuid import uuid4

from drivers.coppeliasim.connection import Connection
from robotcore.errors import BackendError
from robotcore.hal.clock import PeriodicTask
from robotcore.hal.wall_clock import MonotonicClock

PARAMETER = "robotcore.lease"
RENEWAL_S = 1.0
DEAD_S = 3.0
"""Seconds without a renewal after which a lease expires."""

_POLL_S = 0.2


class Lease:
    """The exclusive right to drive the simulator of a connection, from `take` to `release`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._holder = uuid4().hex
        self._renewals = 0
        self._clock = MonotonicClock()
        self._renewal: PeriodicTask | None = None

    def take(self) -> bool:
        """Take the lease, and renew it periodically.

        Returns True if a program has ended without releasing the lease. Raises BackendError if a running program
        holds the lease.
        """
        if note := self._read_note():
            self._await_expiry(note)
        self._write_note(f"{self._holder} 0")
        self._renewal = self._clock.every(RENEWAL_S, self._renew, "coppeliasim lease")
        return bool(note)

    def require(self) -> None:
        """Raise BackendError if another program has taken the lease, because this program did not renew it.

        Then each further call on the connection fails too. Otherwise this program would stop the simulation of the
        other program, and remove its objects.
        """
        note = self._read_note()
        if note and not note.startswith(self._holder):
            lost = BackendError(
                f"coppeliasim: another program has taken over the CoppeliaSim at {self._connection.address}, because "
                f"this one was suspended or busy for more than {DEAD_S:g} s. Run again when the other one has ended",
                kind="lease-lost",
                address=str(self._connection.address),
            )
            self._connection.fail(lost)
            raise lost

    def release(self) -> None:
        """Release the lease if this program holds it.

        It may be called again. It raises no error if the simulator has ended.
        """
        if self._renewal is None:
            return
        self._renewal.stop()
        self._renewal = None
        with suppress(BackendError):
            self.require()
            self._write_note("")

    def _await_expiry(self, note: str) -> None:
        """Wait until a lease is released or has expired. Raises BackendError if its holder renews it.

        This counts reads instead of seconds, because a busy simulator delays renewals and reads alike.
        """
        for _ in range(math.ceil(DEAD_S / _POLL_S)):
            self._clock.sleep_until(self._clock.now() + _POLL_S)
            current = self._read_note()
            if not current:
                return
            if current != note:
                raise BackendError(
                    f"coppeliasim: another program drives the CoppeliaSim at {self._connection.address}. Wait for it "
                    "or stop it, or start a second CoppeliaSim with another port",
                    kind="lease-held",
                    address=str(self._connection.address),
                )

    def _renew(self) -> None:
        self.require()
        self._renewals += 1
        self._write_note(f"{self._holder} {self._renewals}")

    def _read_note(self) -> str:
        note = self._connection.sim("getNamedStringParam", PARAMETER)
        return note.decode(errors="replace") if isinstance(note, bytes) else str(note or "")

    def _write_note(self, note: str) -> None:
        self._connection.sim("setNamedStringParam", PARAMETER, note)

"""Who drives a simulator: a lease that its holder renews, so that two programs do not step one simulation.

It is kept in a parameter of the running CoppeliaSim, which no scene is saved with. Each renewal is a call too, so that
a holder whose app thinks for long is not forgotten by CoppeliaSim.
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
"""A holder that has not renewed for so long is gone."""

_LOOK_S = 0.2


class Lease:
    """The right to drive the simulator of a connection, from `take` to `release`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._holder = uuid4().hex
        self._renewals = 0
        self._clock = MonotonicClock()
        self._renewing: PeriodicTask | None = None

    def take(self) -> bool:
        """Take it, from then on renewing it; return whether it was left behind by somebody who died.

        Raises BackendError where somebody holds it who is alive.
        """
        if note := self._noted():
            self._await_death(note)
        self._note(f"{self._holder} 0")
        self._renewing = self._clock.every(RENEWAL_S, self._renew, "coppeliasim lease")
        return bool(note)

    def require(self) -> None:
        """Raise BackendError where another program has taken it, believing that we are dead: so long were we silent.

        From then on the connection serves us no more, who would stop and remove what is another's.
        """
        note = self._noted()
        if note and not note.startswith(self._holder):
            lost = BackendError(
                f"coppeliasim: this program was suspended or busy for so long that another one has taken over the "
                f"CoppeliaSim at {self._connection.address}. Run again when that has ended"
            )
            self._connection.give_up(lost)
            raise lost

    def release(self) -> None:
        """Give it back, if it is ours. May be called again; raises nothing where the simulator is gone."""
        if self._renewing is None:
            return
        self._renewing.stop()
        self._renewing = None
        with suppress(BackendError):
            self.require()
            self._note("")

    def _await_death(self, note: str) -> None:
        """Wait until it is sure that nobody renews a lease."""
        for _ in range(math.ceil(DEAD_S / _LOOK_S)):  # looks count: a simulator that is busy lets nobody renew
            self._clock.sleep_until(self._clock.now() + _LOOK_S)
            now = self._noted()
            if not now:
                return
            if now != note:
                raise BackendError(
                    f"coppeliasim: another program drives the CoppeliaSim at {self._connection.address}. Wait for it "
                    "or stop it, or start a second CoppeliaSim with another port"
                )

    def _renew(self) -> None:
        self.require()
        self._renewals += 1
        self._note(f"{self._holder} {self._renewals}")

    def _noted(self) -> str:
        note = self._connection.sim("getNamedStringParam", PARAMETER)
        return note.decode(errors="replace") if isinstance(note, bytes) else str(note or "")

    def _note(self, note: str) -> None:
        self._connection.sim("setNamedStringParam", PARAMETER, note)

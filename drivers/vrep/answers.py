"""What has been asked for, and what has come of it so far."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import SimulationHaltedError
from drivers.vrep.wire.messages import Header, Piece
from drivers.vrep.wire.request import Identity, Request


class Answers:
    """The answers to ``reads``; after a step, only those that were given after it.

    An answer counts if the server had our question when it gave it, and, where ``trigger`` is the number of the message
    that triggered a step, if the simulation's time has passed since the trigger was done. What was answered too soon
    is to be asked for again.
    """

    def __init__(self, reads: Sequence[Request[Any]], trigger: int | None = None) -> None:
        self._reads = {read.identity: read for read in reads}
        self._trigger = trigger
        self._begun_ms = None if trigger is not None else -1
        self._asked: dict[Identity, int] = {}
        self._found: dict[Identity, Piece] = {}

    @property
    def are_complete(self) -> bool:
        return len(self._found) == len(self._reads)

    def __getitem__(self, read: Request[Any]) -> Piece:
        return self._found[read.identity]

    def to_ask(self, number: int) -> list[Request[Any]]:
        """Return what to ask for in the message of that number."""
        asked = {one: read for one, read in self._reads.items() if one not in self._found and one not in self._asked}
        self._asked.update(dict.fromkeys(asked, number))
        return list(asked.values())

    def take(self, server: Header, pieces: Iterable[Piece]) -> None:
        """Take what has come; SimulationHaltedError if that says that no step will be taken."""
        for piece in pieces:
            if (piece.command, piece.key) == requests.TRIGGER.identity:
                self._begin(server, piece)
            else:
                self._take(server, piece)
        if self._trigger is not None and server.message >= self._trigger:
            self._check(server)

    def _begin(self, server: Header, piece: Piece) -> None:
        if self._trigger is not None and server.message >= self._trigger:
            if piece.is_failed:
                raise SimulationHaltedError(_NO_STEP)
            self._begun_ms = piece.time_ms

    def _take(self, server: Header, piece: Piece) -> None:
        identity = piece.command, piece.key
        if server.message < self._asked.get(identity, server.message + 1):
            return
        del self._asked[identity]
        if self._begun_ms is not None and piece.time_ms > self._begun_ms:
            self._found[identity] = piece

    def _check(self, server: Header) -> None:
        if self.are_complete:
            return
        if not server.is_running:
            raise SimulationHaltedError("the simulation was stopped: no step can be taken. Run again to start it anew")
        if server.is_paused:
            raise SimulationHaltedError("the simulation is paused: no step can be taken. Let it go on, and run again")


_NO_STEP = "the simulator takes no step: its simulation does not run, or does not wait for our triggers. Run again"

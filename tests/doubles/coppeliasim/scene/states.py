"""The states of a simulation, and the clients that step it."""

from __future__ import annotations

from collections.abc import Hashable
from enum import IntEnum


class State(IntEnum):
    """The values of the API's ``simulation_...``."""

    STOPPED = 0
    PAUSED = 8
    FIRST_AFTER_STOP = 16
    RUNNING = 17
    LAST_BEFORE_PAUSE = 19
    FIRST_AFTER_PAUSE = 20
    ABOUT_TO_STOP = 21
    LAST_BEFORE_STOP = 22

    @property
    def is_advancing(self) -> bool:
        return self >= State.FIRST_AFTER_STOP


class States:
    """The state of the simulation, and the pending request to change it. A request takes effect after the present step.

    >>> states = States()
    >>> states.start()
    >>> states.state.name, states.next().name, states.next().name
    ('FIRST_AFTER_STOP', 'RUNNING', 'RUNNING')
    """

    def __init__(self) -> None:
        self.state = State.STOPPED
        self._is_to_pause = self._is_to_stop = False

    def start(self) -> None:
        """Request that the simulation starts or continues. This has no effect while it runs."""
        if self.state is State.STOPPED:
            self.state = State.FIRST_AFTER_STOP
        elif self.state is State.PAUSED:
            self.state = State.FIRST_AFTER_PAUSE

    def pause(self) -> None:
        self._is_to_pause = self.state.is_advancing

    def stop(self) -> None:
        if self.state is State.PAUSED:
            self.state = State.ABOUT_TO_STOP
        self._is_to_stop = self.state in {State.FIRST_AFTER_STOP, State.RUNNING, State.FIRST_AFTER_PAUSE}

    def next(self) -> State:
        """Advance the state by a step, and return the new state."""
        self.state = self._following()
        return self.state

    def _following(self) -> State:
        if self.state is State.ABOUT_TO_STOP:
            return State.LAST_BEFORE_STOP
        if self.state is State.LAST_BEFORE_STOP:
            self._is_to_pause = self._is_to_stop = False
            return State.STOPPED
        if self.state is State.LAST_BEFORE_PAUSE:
            self._is_to_pause = False
            return State.PAUSED
        if self._is_to_stop:
            return State.ABOUT_TO_STOP
        return State.LAST_BEFORE_PAUSE if self._is_to_pause else State.RUNNING


class Stepping:
    """The stepping level of each client. A client with a level above zero holds time until it requests the next step.

    >>> stepping = Stepping()
    >>> stepping.raise_level("one"), stepping.is_held
    (0, True)
    >>> stepping.request_step("one")
    >>> stepping.is_held
    False
    """

    def __init__(self) -> None:
        self._levels: dict[Hashable, int] = {}
        self._requested: set[Hashable] = set()

    @property
    def is_in_use(self) -> bool:
        """Whether a client steps the simulation."""
        return bool(self._levels)

    @property
    def is_held(self) -> bool:
        """Whether time must wait, because a stepping client has not requested the next step."""
        return not self._levels.keys() <= self._requested

    def level(self, client: Hashable) -> int:
        return self._levels.get(client, 0)

    def raise_level(self, client: Hashable) -> int:
        """Raise a client's level, and return the previous level."""
        before = self.level(client)
        self._levels[client] = before + 1
        return before

    def lower_level(self, client: Hashable) -> int:
        """Lower a client's level, and return the previous level. At level 0 the client no longer steps."""
        before = self._levels.pop(client, 0)
        if before > 1:
            self._levels[client] = before - 1
        return before

    def request_step(self, client: Hashable) -> None:
        """Record a client's request for the next step."""
        self._requested.add(client)

    def finish_step(self) -> None:
        """End a step. All stepping clients then hold time again."""
        self._requested.clear()

    def remove(self, client: Hashable) -> None:
        """Remove a client."""
        self._levels.pop(client, None)
        self._requested.discard(client)

    def reset(self) -> None:
        """Remove all clients, as after each stop."""
        self._levels.clear()
        self._requested.clear()

"""Who holds time: a simulation goes on by a step when every client that steps has asked for it."""

from __future__ import annotations

from collections.abc import Hashable


class Stepping:
    """The stepping level of each client; above zero it holds time until it asks for the next step.

    >>> stepping = Stepping()
    >>> stepping.raise_level("one"), stepping.is_held
    (0, True)
    >>> stepping.ask("one")
    >>> stepping.is_held
    False
    """

    def __init__(self) -> None:
        self._levels: dict[Hashable, int] = {}
        self._asked: set[Hashable] = set()

    @property
    def is_in_use(self) -> bool:
        """Whether anybody steps."""
        return bool(self._levels)

    @property
    def is_held(self) -> bool:
        """Whether somebody steps who has not asked for the next step."""
        return not self._levels.keys() <= self._asked

    def level(self, client: Hashable) -> int:
        return self._levels.get(client, 0)

    def raise_level(self, client: Hashable) -> int:
        """Return the level before."""
        before = self.level(client)
        self._levels[client] = before + 1
        return before

    def lower_level(self, client: Hashable) -> int:
        """Return the level before; at zero the client no longer steps."""
        before = self._levels.pop(client, 0)
        if before > 1:
            self._levels[client] = before - 1
        return before

    def ask(self, client: Hashable) -> None:
        """Note that a client wants the next step."""
        self._asked.add(client)

    def made(self) -> None:
        """A step has been made: everybody holds time again."""
        self._asked.clear()

    def forget(self, client: Hashable) -> None:
        """The client is gone."""
        self._levels.pop(client, None)
        self._asked.discard(client)

    def reset(self) -> None:
        """Nobody steps any more, as after each stop."""
        self._levels.clear()
        self._asked.clear()

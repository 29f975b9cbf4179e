"""What several devices of a robot have in common: one port, one board, one bus."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from contextlib import ExitStack
from typing import Any, Protocol, TypeVar


class Closable(Protocol):
    """What is opened once, whoever asks for it first."""

    def close(self) -> None:
        """Let it go."""


SharedT = TypeVar("SharedT", bound=Closable)


class Shared:
    """Opens what devices have in common when the first of them asks for it; it is closed when all of them are.

    No device closes it, and one that fails in opening leaves it to the others. Devices are opened one after the other;
    while they are open they may call from several threads, so what is shared does its own locking.

    >>> class Port:
    ...     def __init__(self, path):
    ...         self.path = path
    ...     def close(self):
    ...         print(f"close {self.path}")
    >>> shared = Shared()
    >>> left, right = (shared.take(Port, "/dev/ttyUSB0", lambda: Port("/dev/ttyUSB0")) for _ in range(2))
    >>> left is right
    True
    >>> shared.close()
    close /dev/ttyUSB0
    """

    def __init__(self) -> None:
        self._things: dict[tuple[type[Any], Hashable], Any] = {}
        self._opened = ExitStack()

    def take(self, kind: type[SharedT], where: Hashable, open_it: Callable[[], SharedT]) -> SharedT:
        """Return the one of that ``kind`` at that place; open it if there is none, and raise what that raises."""
        thing: SharedT | None = self._things.get((kind, where))
        if thing is None:
            thing = self._things[kind, where] = open_it()
            self._opened.callback(thing.close)
        return thing

    def close(self) -> None:
        """Close all of it, the last one first, even where one fails. May be called again."""
        self._things.clear()
        self._opened.close()

"""What becomes of a command that cannot be executed: an error bit, data all the same, perhaps a text."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.scene.errors import SceneError

Answer = Callable[[Command], bytes]
"""Executes a command; returns the reply's data, or raises RefusedError."""

Answers = dict[int, Answer]
"""By the number of the command."""


class RefusedError(Exception):
    """A command failed; ``data`` goes out with the error bit, ``text`` is kept for whoever asks for the last errors."""

    def __init__(self, text: str | None = None, data: bytes = b"") -> None:
        super().__init__(text)
        self.text, self.data = text, data


@contextmanager
def refusing(function: str, data: bytes = b"") -> Iterator[None]:
    """Turn what the scene refuses into RefusedError that names the simulator's function, as its own messages do."""
    try:
        yield
    except SceneError as error:
        raise RefusedError(f"{error} ({function})", data) from error

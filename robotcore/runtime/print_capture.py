"""Copies the texts that an app prints, so that observers of the run get them."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from threading import get_ident
from types import TracebackType
from typing import Any, TextIO

BURST_CHARACTERS, CHARACTERS_PER_TICK = 8000, 400
"""The greatest number of copied characters in one tick, and in the mean of many ticks."""

MORE = "(the app printed more in this tick)"
"""The last line of a tick if not all texts were copied."""


class PrintCapture:
    """Replaces ``sys.stdout`` within a ``with`` block. Each text goes to the replaced stream, and a copy is kept.

    Only texts of the thread that entered the block are copied.

    >>> prints = PrintCapture()
    >>> with prints:
    ...     print("seen at", 1.2)
    seen at 1.2
    >>> prints.take()
    ('seen at 1.2',)
    """

    def __init__(self) -> None:
        self._copying: _CopyingStream | None = None
        self._thread: int | None = None
        self._is_writing = False
        self._parts: list[str] = []
        self._room = BURST_CHARACTERS
        self._has_more = False

    def __enter__(self) -> None:
        self._thread = get_ident()
        self._restore()
        if (present := sys.stdout) is None:
            return
        if self._copying is None or self._copying.stream is not present:
            self._copying = _CopyingStream(present, self)
        sys.stdout = self._copying

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._thread = None
        self._restore()

    def take(self) -> tuple[str, ...]:
        """Return the copied lines that are not blank, and begin a new tick.

        A line without an end is a line too. If the app printed too much, the last line is `MORE`. Lone surrogates are
        escaped.
        """
        self._room = min(BURST_CHARACTERS, self._room + CHARACTERS_PER_TICK)
        if not self._parts and not self._has_more:
            return ()
        text = "".join(self._parts).encode(errors="backslashreplace").decode()
        lines = [line for line in text.splitlines() if line.strip()]
        if self._has_more:
            lines.append(MORE)
        self._parts, self._has_more = [], False
        return tuple(lines)

    def write(self, stream: TextIO, text: str) -> int:
        """Write a text to a replaced stream. Keep a copy, unless another thread or an outer copying stream wrote it."""
        if self._is_writing or self._thread != get_ident():
            return stream.write(text)
        self._is_writing = True
        try:
            written = stream.write(text)
        finally:
            self._is_writing = False
        self._parts.append(text[: self._room])
        self._room -= len(text)
        if self._room < 0:
            self._room, self._has_more = 0, True
            self._restore()  # so that further prints in this tick cost nothing more
        return written

    def _restore(self) -> None:
        """Restore the replaced stream, unless the app has set another one.

        A ``with`` block of the app over several ticks may restore the copying stream of an earlier tick.
        """
        while isinstance(sys.stdout, _CopyingStream) and sys.stdout.capture is self:
            sys.stdout = sys.stdout.stream


class _CopyingStream:
    """A stream that also passes each text to a capture. All other attributes are those of the replaced stream.

    The app may put a stream of its own around this one. The capture then has another object for that stream.
    """

    def __init__(self, stream: TextIO, capture: PrintCapture) -> None:
        self.stream, self.capture = stream, capture

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        return self.capture.write(self.stream, text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

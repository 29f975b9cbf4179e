"""The output of a running process, within limits: a robot decides how much comes, and when."""

from __future__ import annotations

import os
import selectors
import subprocess
from collections.abc import Iterable, Iterator

from robotcore.text import escape

POLL_S = 0.5
"""`ProcessOutput.pieces` yields an empty piece if no output comes for this time."""

EXCERPT_BYTES = 1 << 13
"""The bytes of stderr that are kept of its beginning, and as many of its end."""

LONGEST_LINE = 1 << 23
"""The most bytes of one line. It limits a list of recordings to about 80 000, below answers.MOST_ITEMS."""

LINE_COST = 1 << 7
"""Each line counts as this many bytes more, because a million empty lines take long to read."""

_PIECE = 1 << 16


class MalformedError(ValueError):
    """The output of a robot is damaged. The message says how, as the end of a sentence."""


class ProcessOutput:
    """The output of a process with pipes: `pieces` of stdout, and an excerpt of stderr.

    Both pipes are read at once. So neither fills memory or disk of the desk, and neither blocks the process.
    """

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._errors = b""

    @property
    def stderr_excerpt(self) -> str:
        """The beginning and the end of stderr, escaped but for its line breaks."""
        return decode_output(self._errors)

    def pieces(self) -> Iterator[bytes]:
        """Yield stdout as it comes until both pipes have ended; an empty piece if none came for `POLL_S`.

        An empty piece comes after each piece of stderr too.
        """
        stdout, stderr = self._process.stdout, self._process.stderr
        assert stdout
        assert stderr
        with selectors.DefaultSelector() as selector:
            for pipe in (stdout, stderr):
                selector.register(pipe, selectors.EVENT_READ)
            while selector.get_map():
                ready = selector.select(POLL_S)
                for key, _ in ready:
                    if not (piece := os.read(key.fd, _PIECE)):
                        selector.unregister(key.fileobj)
                    elif key.fileobj is stdout:
                        yield piece
                    else:
                        self._errors = excerpt(self._errors + piece)
                        yield b""
                if not ready:
                    yield b""


def excerpt(text: bytes) -> bytes:
    """Return a text, or its beginning and its end if it is long."""
    return text if len(text) <= 2 * EXCERPT_BYTES else text[:EXCERPT_BYTES] + b"\n" + text[1 - EXCERPT_BYTES :]


def decode_output(text: bytes) -> str:
    """Return the output of a program as text, with its control characters escaped and its line breaks kept."""
    return escape(text.decode(errors="replace").replace("\r\n", "\n"), keep="\n")


def split_lines(pieces: Iterable[bytes], most: int | None) -> Iterator[bytes]:
    """Yield the lines in pieces, without their ends.

    Raises MalformedError if a line is longer than `LONGEST_LINE`, or if all lines together are longer than ``most``
    bytes. None sets no limit for all.
    """
    rest, total = b"", 0
    for piece in pieces:
        total += len(piece) + LINE_COST * piece.count(b"\n")
        if most is not None and total > most:
            raise MalformedError(f"is longer than {most} bytes")
        *lines, rest = (rest + piece).split(b"\n")
        if len(rest) > LONGEST_LINE:
            raise MalformedError(f"has a line longer than {LONGEST_LINE} bytes")
        yield from lines
    if rest:
        yield rest

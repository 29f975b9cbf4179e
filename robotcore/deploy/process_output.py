"""Read the output of a running process within limits of size and time.

The output comes from a robot, which may send any amount of text.
"""

from __future__ import annotations

import os
import selectors
import subprocess
from collections.abc import Iterable, Iterator

from robotcore.text import escape

POLL_S = 0.5
"""If no output comes for this time, `ProcessOutput.read_pieces` yields an empty piece, in s."""

EXCERPT_BYTES = 1 << 13
"""An excerpt has this many bytes of the beginning of a text, and as many of its end."""

LONGEST_LINE = 1 << 23
"""The longest line that is accepted, in bytes.

A list of about 80 000 recordings fits into a line of this length.
"""

LINE_COST = 1 << 7
"""The bytes that each line counts in addition to its length.

So a limit of bytes also limits the number of empty lines, which take long to read.
"""

_PIECE = 1 << 16


class MalformedError(ValueError):
    """Raised if the output of a robot is damaged. The message is the end of a sentence that begins with ``it``."""


class ProcessOutput:
    """The output of a process: pieces of stdout, and an excerpt of stderr.

    Both pipes are read at the same time, so that the process never blocks on a full pipe. Of stderr only the excerpt is
    kept, so that the output does not fill the client's memory.

    process: a process whose stdout and stderr are pipes.
    """

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._errors = b""

    @property
    def stderr_excerpt(self) -> str:
        """The beginning and the end of stderr. Control characters except for line breaks are escaped."""
        return decode_output(self._errors)

    def read_pieces(self) -> Iterator[bytes]:
        """Yield the pieces of stdout until both pipes have ended.

        The iterator also yields an empty piece if no output came for `POLL_S`, and after each piece of stderr.
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
    """Return a short text as it is, and only the beginning and the end of a long text."""
    return text if len(text) <= 2 * EXCERPT_BYTES else text[:EXCERPT_BYTES] + b"\n" + text[1 - EXCERPT_BYTES :]


def decode_output(text: bytes) -> str:
    """Return the output of a program as text, with its control characters escaped and its line breaks kept."""
    return escape(text.decode(errors="replace").replace("\r\n", "\n"), keep="\n")


def split_lines(pieces: Iterable[bytes], max_bytes: int | None) -> Iterator[bytes]:
    """Yield the lines of the pieces, without their ends.

    max_bytes: the most bytes that all lines together may have; None for no limit.
    Raises MalformedError if a line is longer than `LONGEST_LINE`, or if the limit is exceeded.
    """
    rest, total = b"", 0
    for piece in pieces:
        total += len(piece) + LINE_COST * piece.count(b"\n")
        if max_bytes is not None and total > max_bytes:
            raise MalformedError(f"is longer than {max_bytes} bytes")
        *lines, rest = (rest + piece).split(b"\n")
        if len(rest) > LONGEST_LINE:
            raise MalformedError(f"has a line longer than {LONGEST_LINE} bytes")
        yield from lines
    if rest:
        yield rest

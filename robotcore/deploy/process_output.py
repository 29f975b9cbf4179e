"""Runs a process that may print any amount of text, such as ssh with the output of a robot."""

from __future__ import annotations

import os
import selectors
import signal
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

from robotcore.text import escape

POLL_S = 0.5
"""The time without output, in s, after which `ProcessOutput.read_pieces` yields an empty piece."""

EXCERPT_BYTES = 1 << 13
"""The number of bytes that an excerpt has of the beginning of a text, and of its end."""

MAX_LINE_BYTES = 1 << 23
"""The greatest length of a line, in bytes. A list of about 80 000 recordings fits into such a line."""

LINE_COST = 1 << 7
"""The number of bytes that each line counts in addition to its length, because empty lines take long to read too."""

_PIECE = 1 << 16


class MalformedError(ValueError):
    """Raised if the output of a robot is malformed. The message continues a sentence after the word ``it``."""


class ProcessOutput:
    """The output of a process whose stdout and stderr are pipes.

    It reads both pipes at the same time, so that the process never blocks on a full pipe. It keeps only an excerpt of
    stderr, so that a long output does not fill the memory.
    """

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._errors = b""

    @property
    def status(self) -> int:
        """The exit status of the process, after its end."""
        return self._process.wait()

    @property
    def stderr_excerpt(self) -> str:
        """The beginning and the end of stderr, with control characters except for line breaks escaped."""
        return decode_output(self._errors)

    def read_pieces(self) -> Iterator[bytes]:
        """Yield the pieces of stdout until the process has closed both pipes.

        Also yield an empty piece after each piece of stderr, and after `POLL_S` without output.
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
                        self._errors = _excerpt(self._errors + piece)
                        yield b""
                if not ready:
                    yield b""


@contextmanager
def run_process(
    command: Sequence[str], stdin: bytes, environment: Mapping[str, str] | None = None
) -> Iterator[ProcessOutput]:
    """Run a command during a ``with`` block that reads its output. If the block raises, the command is terminated.

    stdin: the whole input of the command.
    environment: the environment variables; None for those of this process.
    """
    with tempfile.TemporaryFile() as file:
        file.write(stdin)
        file.seek(0)
        # a session of its own, so that the terminal sends no SIGINT
        with subprocess.Popen(  # noqa: S603  no shell
            command,
            stdin=file,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
            start_new_session=True,
        ) as process:
            try:
                yield ProcessOutput(process)
            except BaseException:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGTERM)
                process.wait()
                raise


def _excerpt(text: bytes) -> bytes:
    return text if len(text) <= 2 * EXCERPT_BYTES else text[:EXCERPT_BYTES] + b"\n" + text[1 - EXCERPT_BYTES :]


def decode_output(text: bytes) -> str:
    """Return a program's output as text, with control characters except for line breaks escaped."""
    return escape(text.decode(errors="replace").replace("\r\n", "\n"), keep="\n")


def split_lines(pieces: Iterable[bytes], max_bytes: int | None) -> Iterator[bytes]:
    """Yield the lines of a text that comes in pieces, without their line breaks.

    max_bytes: the greatest length of the text in bytes, see `LINE_COST`; None for no limit.
    Raises MalformedError if the text or a line is too long.
    """
    rest, total = b"", 0
    for piece in pieces:
        total += len(piece) + LINE_COST * piece.count(b"\n")
        if max_bytes is not None and total > max_bytes:
            raise MalformedError(f"is longer than {max_bytes} bytes")
        *lines, rest = (rest + piece).split(b"\n")
        if len(rest) > MAX_LINE_BYTES:
            raise MalformedError(f"has a line longer than {MAX_LINE_BYTES} bytes")
        yield from lines
    if rest:
        yield rest

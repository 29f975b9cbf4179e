"""Asking the board what it runs."""

from __future__ import annotations

import os
import select
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from errno import EINVAL, EIO

from robotcore.errors import FirmwareError
from robotcore.hal.clock import Clock
from robotcore.hal.wall_clock import MonotonicClock

QUESTION, ANSWER = b"v\r", b"robotcore-bridge "
BOOTING_S, BETWEEN_S, TIMES = 2.0, 0.5, 6
"""Opening the port resets the board; its bootloader listens first, and what it hears keeps it there for longer."""


def greet(port: str, baud: int) -> str:
    """Return what the board at a port says of itself: ``robotcore-bridge 1``.

    Raises FirmwareError where nothing of ours answers within `TIMES` questions, or the port cannot be opened.
    """
    clock = MonotonicClock()
    try:
        with _opened(port, baud) as port_file:
            clock.sleep_until(BOOTING_S)
            heard = b"".join(_answers(port_file, clock))
    except (OSError, termios.error) as error:
        raise FirmwareError(f"{port}: cannot be asked what runs there: {error}") from error
    for line in heard.splitlines():
        if ANSWER in line:
            return line[line.index(ANSWER) :].decode("ascii", "replace")
    said = repr(heard.splitlines()[-1][:60]) if heard else "nothing"
    raise FirmwareError(
        f"{port}: was flashed, but asked for its version at {baud} baud it said {said}. "
        "Press the board's reset, and look whether --board and the BAUD of config.h are right"
    )


@contextmanager
def _opened(port: str, baud: int) -> Iterator[int]:
    if (speed := getattr(termios, f"B{baud}", None)) is None:
        raise OSError(EINVAL, f"{baud} baud is no rate that a terminal has")
    line = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        tty.setraw(line)
        settings = termios.tcgetattr(line)
        settings[2] |= termios.CLOCAL
        settings[4] = settings[5] = speed
        termios.tcsetattr(line, termios.TCSANOW, settings)
        yield line
    finally:
        os.close(line)


def _answers(line: int, clock: Clock) -> Iterator[bytes]:
    """Ask until a whole line of ours has come; yield all that comes."""
    heard = b""
    for _ in range(TIMES):
        os.write(line, QUESTION)
        end = clock.now() + BETWEEN_S
        while (left := end - clock.now()) > 0 and select.select([line], [], [], left)[0]:
            if not (some := os.read(line, 256)):
                raise OSError(EIO, "it is gone")
            heard += some
            yield some
            if ANSWER in heard and heard.endswith(b"\n"):
                return

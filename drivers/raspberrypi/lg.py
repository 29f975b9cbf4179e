"""lgpio, the library that talks to the kernel's GPIO chips, without what importing it leaves behind."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from types import ModuleType

FIFO_FOLDER = "LG_WD"
"""Names the folder in which lgpio makes its FIFO, by default the working directory."""

STUB = "pip took an empty one, without gpiochip_open"
"""PyPI's 0.0.0.2 is the newest that fits where there is neither a wheel nor a compiler: one empty file."""

_PI_5 = 0x17
"""The model in a revision code. Source: github.com/raspberrypi/documentation, revision-codes.adoc."""

LINE = "anon_inode:gpio-line"
"""How the link in /proc/PID/fd of a handle of lines begins. Source: Linux, drivers/gpio/gpiolib-cdev.c."""

_FILES = Path("/proc/self/fd")
_LOADING = Lock()
"""The guardian opens its cutoffs at once, each in a thread of its own."""


def load() -> ModuleType:
    """Import lgpio; raises ImportError where it is missing, or is the empty one of PyPI."""
    with _LOADING:
        if "lgpio" not in sys.modules:
            with _fifo_apart():
                import lgpio
            os.register_at_fork(after_in_child=let_go)
        else:
            import lgpio
    if not hasattr(lgpio, "gpiochip_open"):
        raise ImportError(STUB)
    return lgpio  # type: ignore[no-any-return]


def chip_number() -> int:
    """Return which /dev/gpiochip has the header's pins, by the rule of gpiozero's LGPIOFactory.

    Early kernels of the Pi 5 numbered it 4.
    """
    from gpiozero.exc import PinUnknownPi
    from gpiozero.pins.local import get_pi_revision

    try:
        is_pi_5 = (get_pi_revision() >> 4) & 0xFF == _PI_5
    except PinUnknownPi:
        is_pi_5 = False
    return 4 if is_pi_5 and Path("/dev/gpiochip4").exists() else 0


@contextmanager
def _fifo_apart() -> Iterator[None]:
    """Give lgpio a folder of its own for its FIFO, needed while it is opened, and come back to the working directory.

    The library makes the folder its working directory (lgUtil.c), cannot replace a FIFO there that is another user's,
    and takes any for its own that a process beside it has just made (lgNotify.c).
    """
    before = os.environ.get(FIFO_FOLDER)
    here = os.open(".", os.O_RDONLY)
    try:
        with TemporaryDirectory(prefix="lgpio-", dir=before) as folder:
            os.environ[FIFO_FOLDER] = folder
            yield
    finally:
        os.fchdir(here)
        os.close(here)
        os.environ.pop(FIFO_FOLDER)
        if before is not None:
            os.environ[FIFO_FOLDER] = before


def let_go() -> None:
    """Let go of every line: a copy of the app's process must not keep motors on that the app has turned on.

    Each gives way to a file of nothing, so that its number is not given to a file that lgpio would take for its own.
    """
    nothing = os.open(os.devnull, os.O_RDWR)
    for file in tuple(_FILES.iterdir()):
        with suppress(OSError):  # the folder's own, gone by now
            if str(file.readlink()).startswith(LINE):
                os.dup2(nothing, int(file.name), inheritable=False)
    os.close(nothing)

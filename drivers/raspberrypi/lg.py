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

HEADER_DRIVERS = ("pinctrl-rp1", "pinctrl-bcm2835")
"""The kernel's drivers of the chip that has the header: on a Pi 5, and before. Source: github.com/raspberrypi/linux."""

_ROOT = Path("/")
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
            with _private_fifo():
                import lgpio
            os.register_at_fork(after_in_child=release_lines)
        else:
            import lgpio
    if not hasattr(lgpio, "gpiochip_open"):
        raise ImportError(STUB)
    return lgpio  # type: ignore[no-any-return]


def chip_number(root: Path = _ROOT) -> int:
    """Return which /dev/gpiochip has the header's pins: the one whose driver is the header's.

    A Pi 5 has had it as 4, as 0, and beyond 10, and other chips of its own by these numbers: on them are Wi-Fi and the
    card's supply. Where the kernel does not tell, it is by the rule of gpiozero's LGPIOFactory.
    Source: https://github.com/raspberrypi/linux/pull/6144, https://github.com/adafruit/Adafruit_Blinka/issues/1119.
    """
    numbers = {driver: number for number, driver in chips(root)}
    driver = header_driver(root)
    return _chip_by_rule() if driver is None else numbers[driver]


def header_driver(root: Path = _ROOT) -> str | None:
    """Return the name of the kernel's driver of the header, where the kernel tells."""
    drivers = [driver for _, driver in chips(root)]
    return next((driver for driver in HEADER_DRIVERS if driver in drivers), None)


def chips(root: Path) -> Iterator[tuple[int, str]]:
    """Yield the number of each chip, and the name of its driver."""
    for chip in sorted(root.glob("sys/bus/gpio/devices/gpiochip*")):
        yield int(chip.name.removeprefix("gpiochip")), (chip.resolve().parent / "driver").resolve().name


def _chip_by_rule() -> int:
    from gpiozero.exc import PinUnknownPi
    from gpiozero.pins.local import get_pi_revision

    try:
        is_pi_5 = (get_pi_revision() >> 4) & 0xFF == _PI_5
    except PinUnknownPi:
        is_pi_5 = False
    return 4 if is_pi_5 and Path("/dev/gpiochip4").exists() else 0


@contextmanager
def _private_fifo() -> Iterator[None]:
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


def release_lines() -> None:
    """Let go of every line: a copy of the app's process must not keep motors on that the app has turned on.

    Each gives way to a file of nothing, so that its number is not given to a file that lgpio would take for its own.
    """
    nothing = os.open(os.devnull, os.O_RDWR)
    for file in tuple(_FILES.iterdir()):
        with suppress(OSError):  # the folder's own, gone by now
            if str(file.readlink()).startswith(LINE):
                os.dup2(nothing, int(file.name), inheritable=False)
    os.close(nothing)

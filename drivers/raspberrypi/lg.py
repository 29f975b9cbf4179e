"""Import the library lgpio without its side effects, and find the GPIO chip of the header."""

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
"""The environment variable with the folder of lgpio's FIFO. The default is the working directory."""

STUB = "pip installed an empty lgpio, without gpiochip_open"
"""The message for lgpio 0.0.0.2, one empty file, which pip installs without a wheel and a compiler."""

HEADER_DRIVERS = ("pinctrl-rp1", "pinctrl-bcm2835")
"""The kernel drivers of the header's GPIO chip: on a Pi 5, and on older boards.

Source: github.com/raspberrypi/linux."""

_ROOT = Path("/")
_PI_5 = 0x17
"""The number of the Pi 5 in a board's revision code. Source: github.com/raspberrypi/documentation,
revision-codes.adoc."""

LINE = "anon_inode:gpio-line"
"""The beginning of the link target in /proc/PID/fd of a handle of GPIO lines. Source: Linux,
drivers/gpio/gpiolib-cdev.c."""

_LOADING = Lock()
"""Lets only one thread at a time import lgpio. The guardian opens each cutoff in a thread, which imports lgpio."""


def load() -> ModuleType:
    """Return the module lgpio; raises ImportError if lgpio is missing or is the empty package of PyPI."""
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


def find_chip_number(root: Path = _ROOT) -> int:
    """Return the number of the header's GPIO chip, such as 0 for /dev/gpiochip0.

    On a Pi 5 the number depends on the kernel: 4, 0, or above 10. The lines of its other chips switch Wi-Fi and the
    supply of the SD card, and must not be changed. So the chip is found by its kernel driver. If the kernel reports no
    driver, the number is 4 or 0, as in gpiozero's LGPIOFactory.

    Source: https://github.com/raspberrypi/linux/pull/6144, https://github.com/adafruit/Adafruit_Blinka/issues/1119.
    """
    numbers = {driver: number for number, driver in list_chips(root)}
    driver = find_header_driver(root)
    if driver is not None:
        return numbers[driver]
    from gpiozero.exc import PinUnknownPi
    from gpiozero.pins.local import get_pi_revision

    try:
        is_pi_5 = (get_pi_revision() >> 4) & 0xFF == _PI_5
    except PinUnknownPi:
        is_pi_5 = False
    return 4 if is_pi_5 and Path("/dev/gpiochip4").exists() else 0


def find_header_driver(root: Path = _ROOT) -> str | None:
    """Return the kernel driver of the header's GPIO chip; None if the kernel reports none."""
    drivers = [driver for _, driver in list_chips(root)]
    return next((driver for driver in HEADER_DRIVERS if driver in drivers), None)


def list_chips(root: Path) -> Iterator[tuple[int, str]]:
    """Yield the number and the kernel driver of each GPIO chip."""
    for chip in sorted(root.glob("sys/bus/gpio/devices/gpiochip*")):
        yield int(chip.name.removeprefix("gpiochip")), (chip.resolve().parent / "driver").resolve().name


@contextmanager
def _private_fifo() -> Iterator[None]:
    # At its import, lgpio changes the working directory to FIFO_FOLDER (lgUtil.c), and creates a FIFO there
    # (lgNotify.c). In a shared folder this fails if another user has a FIFO there, and two processes may share a FIFO.
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
    """Close all handles of GPIO lines in a forked process, so that it does not hold the lines of the app's motors.

    Each handle is replaced by /dev/null. If the file descriptor became free, a later file might get it, and lgpio would
    use that file as its handle.
    """
    nothing = os.open(os.devnull, os.O_RDWR)
    for file in tuple(Path("/proc/self/fd").iterdir()):
        with suppress(OSError):  # `iterdir` has closed its own handle, which it listed too
            if str(file.readlink()).startswith(LINE):
                os.dup2(nothing, int(file.name), inheritable=False)
    os.close(nothing)

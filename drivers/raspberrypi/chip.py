"""The header's GPIO chip without gpiozero: import lgpio, find the chip, claim lines, and find the holder of a line."""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from types import ModuleType

from robotcore.errors import BackendError
from robotcore.processes import describe_process, list_open_files

FIFO_FOLDER = "LG_WD"
"""The environment variable with the folder of lgpio's FIFO. The default is the working directory."""

STUB = "pip installed an empty lgpio, without gpiochip_open: run pip uninstall lgpio"
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


AT_THE_DESK = "At the desk: --backend virtualpi"
ON_THE_PI = (
    "On the Pi: sudo apt install python3-lgpio, and pip install 'robotcore[pi]' in a venv made with "
    "--system-site-packages"
)
INSTALL = f"{ON_THE_PI}. {AT_THE_DESK}"


class HeldLineError(BackendError):
    """Another process holds a GPIO line."""

    kind = "gpio-held"


class Chip:
    """The open GPIO chip of the header.

    `close` frees the lines that this object has claimed. On a Raspberry Pi, a freed line keeps its level.
    """

    def __init__(self) -> None:
        """Open the GPIO chip. Raises BackendError if that fails."""
        self._lgpio, number = load(), find_chip_number()
        try:
            self._handle = self._lgpio.gpiochip_open(number)
        except self._lgpio.error as error:
            raise BackendError(explain_closed_chip(number), kind="gpio-chip-closed") from error

    def claim_low(self, gpios: Sequence[int]) -> None:
        """Claim GPIO lines as low outputs with pull-downs. Lines that this object has already claimed do not change.

        Raises HeldLineError if another process holds any of the lines. The other lines are claimed even then.
        """
        if held := [gpio for gpio in gpios if not self._is_claimed(gpio)]:
            held_by = "; ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in held)
            raise HeldLineError(f"{held_by}. End that program, then try again", gpios=tuple(held))

    def write(self, gpio: int, *, is_high: bool) -> None:
        """Set the level of a claimed line."""
        self._lgpio.gpio_write(self._handle, gpio, int(is_high))

    def close(self) -> None:
        self._lgpio.gpiochip_close(self._handle)

    def _is_claimed(self, gpio: int) -> bool:
        try:
            self._lgpio.gpio_claim_output(self._handle, gpio, 0, self._lgpio.SET_PULL_DOWN)
        except self._lgpio.error as error:
            if error.value != self._lgpio.error_text(self._lgpio.GPIO_BUSY):
                raise
            return False
        return True


def explain_closed_chip(number: int) -> str:
    """Return why the GPIO chip ``number`` cannot be opened, and the remedy. lgpio reports no reason."""
    chip = Path(f"/dev/gpiochip{number}")
    if not chip.exists():
        return f"there is no {chip}: this is no Raspberry Pi. {AT_THE_DESK}"
    if not os.access(chip, os.R_OK | os.W_OK):
        return f"no permission for {chip}. Run sudo usermod -aG gpio $USER, then log out and in again"
    return f"{chip} cannot be opened. Run robotcore doctor on the robot"


_LINE_KEY = "gpio-line:"
_CHIP_KEY = "gpio-chip:"

_GET_LINE_INFO = 0xC100B405
"""The ioctl request GPIO_V2_GET_LINEINFO_IOCTL. Source: Linux, include/uapi/linux/gpio.h."""

_LINE_INFO = struct.Struct("32s 32s I 188x")
"""The name, the consumer and the offset in struct gpio_v2_line_info, which that ioctl fills."""


def find_holder(gpio: int, root: Path = _ROOT) -> str:
    """Return the holder of a GPIO line, such as ``process 1234 (python3)``, or ``an unknown holder``.

    If a kernel driver holds the line, the result has the line's label. Kernels before 6.2 do not list the lines of a
    process. Only root can find the processes of other users.
    """
    chip = (root / f"dev/gpiochip{find_chip_number(root)}").resolve().name  # a Pi 5's gpiochip4 may be a link
    line = {f"{_CHIP_KEY} {chip}", f"{_LINE_KEY} {gpio}"}
    holders = dict.fromkeys(process for process, info in _list_handles(root / "proc") if line <= info)
    label = _read_label(root / "dev" / chip, gpio)
    return " or ".join(holders) or f"an unknown holder{label and f', as {label!r}'}"


def _list_handles(proc: Path) -> Iterator[tuple[str, set[str]]]:
    for file in list_open_files(proc):
        if file.link.startswith(LINE):
            with suppress(OSError):  # the process may have closed the handle
                info = (proc / f"{file.process}/fdinfo/{file.number}").read_text()
                yield describe_process(file.process, proc), {" ".join(line.split()) for line in info.splitlines()}


def _read_label(chip: Path, gpio: int) -> str:
    import fcntl

    info = bytearray(_LINE_INFO.pack(b"", b"", gpio))
    try:
        with chip.open("rb", buffering=0) as file:
            fcntl.ioctl(file, _GET_LINE_INFO, info)
    except OSError:
        return ""
    return str(_LINE_INFO.unpack(info)[1].rstrip(b"\0").decode(errors="replace"))

"""The GPIO chip of the header: claim its lines beside the app's pin factory, and find which process holds a line."""

from __future__ import annotations

import fcntl
import os
import struct
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from drivers.raspberrypi.lg import LINE, chip_number, load
from robotcore.errors import BackendError
from robotcore.processes import describe_process, list_open_files

AT_THE_DESK = "At the desk: --backend virtualpi"


class HeldError(BackendError):
    """A line is another process's."""

    kind = "gpio-held"


class Chip:
    """Open until `close`, which frees what was claimed; a Raspberry Pi's kernel lets a freed line keep its level."""

    def __init__(self) -> None:
        """Raises BackendError where the chip cannot be opened."""
        self._lgpio, number = load(), chip_number()
        try:
            self._handle = self._lgpio.gpiochip_open(number)
        except self._lgpio.error as error:
            raise BackendError(explain_closed_chip(number), kind="gpio-chip-closed") from error

    def claim_low(self, gpios: Sequence[int]) -> None:
        """Make lines low outputs of this process; those that it has claimed before stay as they are.

        Pulled down, they are low too when nobody drives them any more. All are tried. Raises HeldError where another
        process has one.
        """
        if held := [gpio for gpio in gpios if not self._is_claimed(gpio)]:
            words = "; ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in held)
            raise HeldError(f"{words}. End that program first", gpios=tuple(held))

    def write(self, gpio: int, *, is_high: bool) -> None:
        """Set the level of a line that is claimed."""
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
    """Return why a chip could not be opened, and what to do, which lgpio does not tell."""
    chip = Path(f"/dev/gpiochip{number}")
    if not chip.exists():
        return f"there is no {chip}: this is no Raspberry Pi. {AT_THE_DESK}"
    if not os.access(chip, os.R_OK | os.W_OK):
        return f"no permission for {chip}. sudo usermod -aG gpio $USER, then log in again"
    return f"{chip} cannot be opened. Run robotcore doctor on the robot"


_ROOT = Path("/")
_LINE_KEY = "gpio-line:"
_CHIP_KEY = "gpio-chip:"

_GET_LINE_INFO = 0xC100B405
"""GPIO_V2_GET_LINEINFO_IOCTL. Source: Linux, include/uapi/linux/gpio.h, as `_LINE_INFO`."""

_LINE_INFO = struct.Struct("32s 32s I 188x")
"""The begin of struct gpio_v2_line_info: name, consumer, offset."""


def find_holder(gpio: int, root: Path = _ROOT) -> str:
    """Return words for who holds a line: "process 1234 (python3)", or "somebody" where it cannot be told.

    Since 6.2 the kernel tells the lines of each handle (/proc/PID/fdinfo); where it does not, whoever has a handle may
    have this line. A holder in the kernel has no process, but a label. Other users' handles are seen by root only.
    """
    chip = (root / f"dev/gpiochip{chip_number(root)}").resolve().name  # gpiochip4 of a Pi 5 may be a link to gpiochip0
    handles = list(_handles(root / "proc"))
    if holders := _join(process for process, info in handles if _holds_line(info, chip, gpio)):
        return holders
    this = f"process {os.getpid()} ("
    suspects = _join(process for process, info in handles if _LINE_KEY not in info and not process.startswith(this))
    who = f"perhaps {suspects}" if suspects else "somebody"
    return ", as ".join(filter(None, [who, _label(root / "dev" / chip, gpio)]))


def _handles(proc: Path) -> Iterator[tuple[str, str]]:
    """Yield each handle of GPIO lines: the words for its process, and the kernel's information on the handle."""
    for file in list_open_files(proc):
        if file.link.startswith(LINE):
            with suppress(OSError):  # closed meanwhile
                info = (proc / f"{file.process}/fdinfo/{file.number}").read_text()
                yield describe_process(file.process, proc), info


def _holds_line(info: str, chip: str, gpio: int) -> bool:
    lines = {" ".join(line.split()) for line in info.splitlines()}
    return f"{_LINE_KEY} {gpio}" in lines and f"{_CHIP_KEY} {chip}" in lines


def _join(processes: Iterator[str]) -> str:
    return " or ".join(dict.fromkeys(processes))


def _label(chip: Path, gpio: int) -> str:
    """Return what the holder calls a line, quoted; nothing where the chip does not tell."""
    info = bytearray(_LINE_INFO.pack(b"", b"", gpio))
    try:
        with chip.open("rb", buffering=0) as file:
            fcntl.ioctl(file, _GET_LINE_INFO, info)
    except OSError:
        return ""
    label = _LINE_INFO.unpack(info)[1].rstrip(b"\0").decode(errors="replace")
    return repr(label) if label else ""

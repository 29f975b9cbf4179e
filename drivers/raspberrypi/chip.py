"""Claim lines of the header's GPIO chip without gpiozero, and find the holder of a line."""

from __future__ import annotations

import fcntl
import os
import struct
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from drivers.raspberrypi.lg import LINE, find_chip_number, load
from robotcore.errors import BackendError
from robotcore.processes import describe_process, list_open_files

AT_THE_DESK = "At the desk: --backend virtualpi"


class HeldError(BackendError):
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

        Raises HeldError if another process holds any of the lines. The other lines are claimed even then.
        """
        if held := [gpio for gpio in gpios if not self._is_claimed(gpio)]:
            held_by = "; ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in held)
            raise HeldError(f"{held_by}. End that program, then try again", gpios=tuple(held))

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


_ROOT = Path("/")
_LINE_KEY = "gpio-line:"
_CHIP_KEY = "gpio-chip:"

_GET_LINE_INFO = 0xC100B405
"""The ioctl request GPIO_V2_GET_LINEINFO_IOCTL. Source: Linux, include/uapi/linux/gpio.h."""

_LINE_INFO = struct.Struct("32s 32s I 188x")
"""The name, the consumer and the offset in struct gpio_v2_line_info, which that ioctl fills."""


def find_holder(gpio: int, root: Path = _ROOT) -> str:
    """Return the holder of a GPIO line, such as ``process 1234 (python3)``, or ``an unknown holder``.

    Kernels before 6.2 do not list the lines of a handle in /proc/PID/fdinfo. Then the result names every process with
    any GPIO line open, after the word ``perhaps``. If a kernel driver holds the line, the result has the line's label.
    Only root can find the processes of other users.
    """
    chip = (root / f"dev/gpiochip{find_chip_number(root)}").resolve().name  # a Pi 5's gpiochip4 may be a link
    handles = list(_list_handles(root / "proc"))
    line = f"{_CHIP_KEY} {chip}", f"{_LINE_KEY} {gpio}"
    if holders := _join(process for process, info in handles if {*line} <= set(info)):
        return holders
    this = f"process {os.getpid()} ("
    suspects = _join(
        process
        for process, info in handles
        if not any(line.startswith(_LINE_KEY) for line in info) and not process.startswith(this)
    )
    holder = f"perhaps {suspects}" if suspects else "an unknown holder"
    return ", as ".join(filter(None, [holder, _read_label(root / "dev" / chip, gpio)]))


def _list_handles(proc: Path) -> Iterator[tuple[str, list[str]]]:
    for file in list_open_files(proc):
        if file.link.startswith(LINE):
            with suppress(OSError):  # the process may have closed the handle
                info = (proc / f"{file.process}/fdinfo/{file.number}").read_text()
                yield describe_process(file.process, proc), [" ".join(line.split()) for line in info.splitlines()]


def _join(processes: Iterator[str]) -> str:
    return " or ".join(dict.fromkeys(processes))


def _read_label(chip: Path, gpio: int) -> str:
    info = bytearray(_LINE_INFO.pack(b"", b"", gpio))
    try:
        with chip.open("rb", buffering=0) as file:
            fcntl.ioctl(file, _GET_LINE_INFO, info)
    except OSError:
        return ""
    label = _LINE_INFO.unpack(info)[1].rstrip(b"\0").decode(errors="replace")
    return repr(label) if label else ""

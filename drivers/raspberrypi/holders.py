"""Who holds a GPIO, as far as the kernel tells: words for somebody whose line is busy."""

from __future__ import annotations

import fcntl
import os
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from drivers.raspberrypi.lg import LINE, chip_number

_ROOT = Path("/")
_LINE = "gpio-line:"
_CHIP = "gpio-chip:"

_GET_LINE_INFO = 0xC100B405
"""GPIO_V2_GET_LINEINFO_IOCTL. Source: Linux, include/uapi/linux/gpio.h, as `_LINE_INFO`."""

_LINE_INFO = struct.Struct("32s 32s I 188x")
"""The begin of struct gpio_v2_line_info: name, consumer, offset."""


def held_by(gpio: int, root: Path = _ROOT) -> str:
    """Return words for who holds a line: "process 1234 (python3)", or "somebody" where it cannot be told.

    Since 6.2 the kernel tells the lines of each handle (/proc/PID/fdinfo); where it does not, whoever has a handle may
    have this line. A holder in the kernel has no process, but a label. Other users' handles are seen by root only.
    """
    chip = (root / f"dev/gpiochip{chip_number(root)}").resolve().name  # gpiochip4 of a Pi 5 may be a link to gpiochip0
    handles = list(_handles(root / "proc"))
    if holders := _all_of(process for process, info in handles if _tells(info, chip, gpio)):
        return holders
    this = f"process {os.getpid()} ("
    suspects = _all_of(process for process, info in handles if _LINE not in info and not process.startswith(this))
    who = f"perhaps {suspects}" if suspects else "somebody"
    return ", as ".join(filter(None, [who, _label(root / "dev" / chip, gpio)]))


def _handles(proc: Path) -> Iterator[tuple[str, str]]:
    """Yield the process of each handle of GPIO lines, in words, and what the kernel tells of the handle."""
    for process in sorted(proc.glob("[0-9]*"), key=lambda process: int(process.name)):
        with suppress(OSError):  # gone, or another user's
            for file in (process / "fd").iterdir():
                with suppress(OSError):  # closed meanwhile
                    if str(file.readlink()).startswith(LINE):
                        name = (process / "comm").read_text().strip()
                        yield f"process {process.name} ({name})", (process / "fdinfo" / file.name).read_text()


def _tells(info: str, chip: str, gpio: int) -> bool:
    lines = {" ".join(line.split()) for line in info.splitlines()}
    return f"{_LINE} {gpio}" in lines and f"{_CHIP} {chip}" in lines


def _all_of(processes: Iterator[str]) -> str:
    return " or ".join(dict.fromkeys(processes))


def _label(chip: Path, gpio: int) -> str:
    """Return what the holder calls a line, quoted; nothing where the chip does not tell."""
    told = bytearray(_LINE_INFO.pack(b"", b"", gpio))
    try:
        with chip.open("rb", buffering=0) as file:
            fcntl.ioctl(file, _GET_LINE_INFO, told)
    except OSError:
        return ""
    label = _LINE_INFO.unpack(told)[1].rstrip(b"\0").decode(errors="replace")
    return repr(label) if label else ""

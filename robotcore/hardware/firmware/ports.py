"""The port that a board is at: found, and held to be free."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from robotcore.errors import FirmwareError, UsageError

DEVICES = Path("/dev")
PATTERNS = ("ttyACM*", "ttyUSB*")
"""What Linux calls an Uno's port, and that of a Nano's converter."""


def only_port(devices: Path = DEVICES) -> str:
    """Return the one serial port of USB that there is; raises UsageError where there is none, or a choice."""
    ports = sorted(str(port) for pattern in PATTERNS for port in devices.glob(pattern))
    if len(ports) == 1:
        return ports[0]
    if ports:
        raise UsageError(f"which board is it? There are {', '.join(ports)}. Say --port {ports[0]}")
    raise UsageError("no board is plugged in: there is no /dev/ttyACM* or /dev/ttyUSB*. Plug it in, or name its --port")


def require_free(port: str) -> None:
    """Raise FirmwareError unless a port is there, may be used, and nobody else has it open."""
    if not Path(port).is_char_device():
        raise FirmwareError(f"{port}: is no port. Is the board plugged in? `ls /dev/serial/by-id` names those that are")
    if not os.access(port, os.R_OK | os.W_OK):
        raise FirmwareError(f"{port}: may not be used by you. sudo usermod -aG dialout $USER, and log in anew")
    if holders := ", ".join(_holders(Path(port).resolve())):
        raise FirmwareError(f"{port}: is in use by {holders}. End that first: flashing would cut into what it does")


def _holders(device: Path) -> Iterator[str]:
    """Yield who else has a device open, by name and number, as far as we may see."""
    others = (process for process in Path("/proc").glob("[0-9]*") if process.name != str(os.getpid()))
    for process in others:
        with suppress(OSError):  # somebody else's, or gone meanwhile
            if any(file.readlink() == device for file in (process / "fd").iterdir()):
                yield f"{(process / 'comm').read_text().strip()} ({process.name})"

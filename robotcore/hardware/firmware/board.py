"""The types of boards that the firmware supports, the firmware's sketch, and a board's port and version."""

from __future__ import annotations

import os
import re
import select
import shutil
from errno import EINVAL, EIO
from pathlib import Path

from robotcore.errors import FirmwareError, UsageError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_holders
from robotcore.system import require_posix

BOARDS = {"uno": "arduino:avr:uno", "nano": "arduino:avr:nano", "nano-old": "arduino:avr:nano:cpu=atmega328old"}
"""The types of boards, and the fully qualified board name of each for arduino-cli."""


SKETCH = "robotcore_bridge"
_SKETCH_FOLDERS = (Path(__file__).parent / SKETCH, Path(__file__).parents[3] / "firmware" / SKETCH)
"""The folders in which the sketch may be: the first in an installed robotcore, the second in a clone of the project."""


def shipped_sketch() -> Path:
    """Return the folder of the sketch that is shipped with robotcore."""
    return next(place for place in _SKETCH_FOLDERS if (place / f"{SKETCH}.ino").is_file())


def find_sketch(folder: Path | None) -> Path:
    """Return the folder of a sketch, that is, the folder FOLDER with the file FOLDER.ino.

    folder: the folder of a sketch, or the folder that was passed to `copy_sketch`. None means the shipped sketch.

    Raises UsageError if there is no sketch.
    """
    if folder is None:
        return shipped_sketch()
    for place in (folder.absolute(), folder.absolute() / SKETCH):
        if (place / f"{place.name}.ino").is_file():
            return place
    raise UsageError(
        f"{folder}: it has no sketch {folder.name}.ino. Copy the shipped sketch: robotcore firmware copy DIR",
        kind="sketch-missing",
        folder=str(folder),
    )


def read_baud(folder: Path) -> int:
    """Return the baud rate from the config.h of a sketch, or 57600 if the file does not have it."""
    header = folder / "config.h"
    found = re.search(r"(?m)^#define BAUD (\d+)", header.read_text(encoding="utf-8")) if header.is_file() else None
    return int(found[1]) if found else 57600


def copy_sketch(into: Path) -> Path:
    """Copy the shipped sketch into a folder, and return the folder of the copy.

    Raises UsageError if there is a copy already, or if the folder cannot be written.
    """
    target = into / SKETCH
    try:
        shutil.copytree(shipped_sketch(), target)
    except OSError as error:
        kind, text = "folder-not-writable", f"{error.strerror}. Name a folder that you can write"
        if isinstance(error, FileExistsError):
            kind, text = "sketch-exists", "exists already. Edit its config.h, or name another folder"
        raise UsageError(f"{target}: {text}", kind=kind, folder=str(target)) from error
    return target


def find_only_port(devices: Path = Path("/dev")) -> str:
    """Return the only USB serial port. Raises UsageError if there is none or more than one."""
    ports = sorted(str(port) for pattern in ("ttyACM*", "ttyUSB*") for port in devices.glob(pattern))
    if len(ports) == 1:
        return ports[0]
    if ports:
        raise UsageError(
            f"several boards are plugged in: {', '.join(ports)}. Name the port, such as --port {ports[0]}",
            kind="port-ambiguous",
            ports=ports,
        )
    raise UsageError(
        "no board is plugged in: there is no /dev/ttyACM* and no /dev/ttyUSB*. Plug the board in, or name its port "
        "with --port",
        kind="no-board",
    )


def require_terminals() -> None:
    """Raise UnsupportedSystemError if this program cannot ask a board for its version on this system."""
    remedy = "Compile with robotcore firmware build, and flash with arduino-cli upload"
    require_posix("robotcore firmware flash", "POSIX terminals, to ask the board for its version", remedy)


def require_free(port: str) -> None:
    """Raise FirmwareError if the port does not exist, is not accessible to this user, or is open in another process."""
    if not Path(port).is_char_device():
        raise FirmwareError(
            f"{port}: it is not a serial port. Plug the board in. List the ports: ls /dev/serial/by-id",
            kind="port-missing",
            port=port,
        )
    if not os.access(port, os.R_OK | os.W_OK):
        raise FirmwareError(
            f"{port}: you have no permission to open it. Add yourself to the group, sudo usermod -aG dialout $USER, "
            "and log in again",
            kind="port-permission",
            port=port,
        )
    if holders := describe_holders(port):
        raise FirmwareError(
            f"{port}: it is open in {holders}. End that program, because flashing would disturb it",
            kind="port-in-use",
            port=port,
            holders=holders,
        )


QUESTION, ANSWER = b"v\r", b"robotcore-bridge "
BOOT_S = 2.0
"""The pause after the port was opened, in seconds. Opening resets the board, and earlier bytes would keep it in its
bootloader."""

QUESTION_PERIOD_S, MAX_QUESTIONS = 0.5, 6


def read_version(port: str, baud: int) -> str:
    """Return the version of the firmware of the board at a port, such as ``robotcore-bridge 1``.

    Raises FirmwareError if the port cannot be opened, or if the firmware does not answer in time.
    """
    import termios

    try:
        received = _ask_for_version(port, baud)
    except (OSError, termios.error) as error:
        raise FirmwareError(
            f"{port}: the version of the firmware cannot be read: {error}", kind="port-unusable", port=port
        ) from error
    for line in received.splitlines():
        if ANSWER in line:
            return line[line.index(ANSWER) :].decode("ascii", "replace")
    answer = repr(received.splitlines()[-1][:60]) if received else "nothing"
    raise FirmwareError(
        f"{port}: the board was flashed, but it does not report the version of its firmware at {baud} baud (answer: "
        f"{answer}). Press its reset button, and check --board and the BAUD of config.h",
        kind="wrong-firmware",
        port=port,
        baud=baud,
    )


def _ask_for_version(port: str, baud: int) -> bytes:
    import termios
    import tty

    if (speed := getattr(termios, f"B{baud}", None)) is None:
        raise OSError(EINVAL, f"a terminal cannot be set to {baud} baud")
    clock, received = MonotonicClock(), b""
    line = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        tty.setraw(line)
        settings = termios.tcgetattr(line)
        settings[2] |= termios.CLOCAL
        settings[4] = settings[5] = speed
        termios.tcsetattr(line, termios.TCSANOW, settings)
        clock.sleep_until(BOOT_S)
        for _ in range(MAX_QUESTIONS):
            os.write(line, QUESTION)
            end = clock.now() + QUESTION_PERIOD_S
            while (left := end - clock.now()) > 0 and select.select([line], [], [], left)[0]:
                if not (some := os.read(line, 256)):
                    raise OSError(EIO, "the port is lost")
                received += some
                if ANSWER in received and received.endswith(b"\n"):
                    return received
        return received
    finally:
        os.close(line)

"""The boards that the firmware is for, its source, the port of a board, and what runs on it."""

from __future__ import annotations

import os
import re
import select
import shutil
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from errno import EINVAL, EIO
from pathlib import Path

from robotcore.errors import FirmwareError, UsageError
from robotcore.hal.clock import Clock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_holders


@dataclass(frozen=True)
class Board:
    """A board as the Arduino tools know it.

    ``fqbn`` names it to arduino-cli, ``variant`` its pins in the Arduino core; its bootloader takes ``flash_bytes``
    at ``upload_baud``. The figures are those of the Arduino core's boards.txt.
    """

    name: str
    fqbn: str
    variant: str
    macro: str
    upload_baud: int
    flash_bytes: int


BOARDS = {
    board.name: board
    for board in (
        Board("uno", "arduino:avr:uno", "standard", "ARDUINO_AVR_UNO", 115200, 32256),
        Board("nano", "arduino:avr:nano", "eightanaloginputs", "ARDUINO_AVR_NANO", 115200, 30720),
        Board("nano-old", "arduino:avr:nano:cpu=atmega328old", "eightanaloginputs", "ARDUINO_AVR_NANO", 57600, 30720),
    )
}


SKETCH = "robotcore_bridge"
SKETCH_FOLDERS = (Path(__file__).parent / SKETCH, Path(__file__).parents[3] / "firmware" / SKETCH)
"""In an installed robotcore, and in a clone of the project."""


def shipped_sketch() -> Path:
    """Return the folder of the sketch that came with this robotcore."""
    return next(place for place in SKETCH_FOLDERS if (place / f"{SKETCH}.ino").is_file())


def find_sketch(folder: Path | None) -> Path:
    """Return the folder of a sketch: somebody's own, or what `copy_sketch` made of it, or the shipped one.

    Raises UsageError where it holds none: Arduino wants FOLDER/FOLDER.ino.
    """
    if folder is None:
        return shipped_sketch()
    for place in (folder.absolute(), folder.absolute() / SKETCH):
        if (place / f"{place.name}.ino").is_file():
            return place
    raise UsageError(
        f"{folder}: holds no sketch {folder.name}.ino. `robotcore firmware copy DIR` makes one to change",
        kind="sketch-missing",
        folder=str(folder),
    )


def read_baud(folder: Path) -> int:
    """Return at how many baud a sketch talks, as its config.h says; 57600 where it says nothing."""
    header = folder / "config.h"
    said = re.search(r"(?m)^#define BAUD (\d+)", header.read_text()) if header.is_file() else None
    return int(said[1]) if said else 57600


def copy_sketch(into: Path) -> Path:
    """Copy the shipped sketch into a folder, to be wired in its config.h; return the sketch's folder.

    Raises UsageError where there is one already, or the folder cannot be written.
    """
    target = into / SKETCH
    try:
        shutil.copytree(shipped_sketch(), target)
    except FileExistsError as error:
        raise UsageError(
            f"{target}: is there already. Edit its config.h, or name another folder",
            kind="sketch-exists",
            folder=str(target),
        ) from error
    except OSError as error:
        raise UsageError(
            f"{target}: {error.strerror}. Name a folder that you may write",
            kind="folder-not-writable",
            folder=str(target),
        ) from error
    return target


DEVICE_FOLDER = Path("/dev")
PORT_PATTERNS = ("ttyACM*", "ttyUSB*")
"""What Linux calls an Uno's port, and that of a Nano's converter."""


def find_only_port(devices: Path = DEVICE_FOLDER) -> str:
    """Return the one serial port of USB that there is; raises UsageError where there is none, or a choice."""
    ports = sorted(str(port) for pattern in PORT_PATTERNS for port in devices.glob(pattern))
    if len(ports) == 1:
        return ports[0]
    if ports:
        raise UsageError(
            f"which board is it? There are {', '.join(ports)}. Say --port {ports[0]}",
            kind="port-ambiguous",
            ports=ports,
        )
    raise UsageError(
        "no board is plugged in: there is no /dev/ttyACM* or /dev/ttyUSB*. Plug it in, or name its --port",
        kind="no-board",
    )


def require_free(port: str) -> None:
    """Raise FirmwareError unless a port is there, may be used, and nobody else has it open."""
    if not Path(port).is_char_device():
        raise FirmwareError(
            f"{port}: is no port. Is the board plugged in? `ls /dev/serial/by-id` names those that are",
            kind="port-missing",
            port=port,
        )
    if not os.access(port, os.R_OK | os.W_OK):
        raise FirmwareError(
            f"{port}: may not be used by you. sudo usermod -aG dialout $USER, and log in anew",
            kind="port-permission",
            port=port,
        )
    if holders := describe_holders(port):
        raise FirmwareError(
            f"{port}: is in use by {holders}. End that first: flashing would cut into what it does",
            kind="port-in-use",
            port=port,
            holders=holders,
        )


QUESTION, ANSWER = b"v\r", b"robotcore-bridge "
BOOTING_S, BETWEEN_S, TIMES = 2.0, 0.5, 6
"""Opening the port resets the board; its bootloader listens first, and what it hears keeps it there for longer."""


def read_version(port: str, baud: int) -> str:
    """Return what the board at a port says of itself: ``robotcore-bridge 1``.

    Raises FirmwareError where nothing of ours answers within `TIMES` questions, or the port cannot be opened.
    """
    clock = MonotonicClock()
    try:
        with _open_port(port, baud) as port_file:
            clock.sleep_until(BOOTING_S)
            heard = b"".join(_read_answers(port_file, clock))
    except (OSError, termios.error) as error:
        raise FirmwareError(
            f"{port}: cannot be asked what runs there: {error}", kind="port-unusable", port=port
        ) from error
    for line in heard.splitlines():
        if ANSWER in line:
            return line[line.index(ANSWER) :].decode("ascii", "replace")
    said = repr(heard.splitlines()[-1][:60]) if heard else "nothing"
    raise FirmwareError(
        f"{port}: was flashed, but asked for its version at {baud} baud it said {said}. "
        "Press the board's reset, and look whether --board and the BAUD of config.h are right",
        kind="wrong-firmware",
        port=port,
        baud=baud,
    )


@contextmanager
def _open_port(port: str, baud: int) -> Iterator[int]:
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


def _read_answers(line: int, clock: Clock) -> Iterator[bytes]:
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

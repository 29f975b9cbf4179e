"""The boards that the firmware supports; find the firmware's source, find a board's port, and read its version."""

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
class BoardType:
    """A microcontroller board, with the values from boards.txt of the Arduino core."""

    name: str
    fqbn: str
    """The board's name for arduino-cli."""
    variant: str
    """The pin layout of the board in the Arduino core."""
    macro: str
    """The preprocessor macro of the board."""
    upload_baud: int
    """The baud rate of its bootloader."""
    flash_bytes: int
    """The flash memory for a program, in bytes."""


BOARDS = {
    board.name: board
    for board in (
        BoardType("uno", "arduino:avr:uno", "standard", "ARDUINO_AVR_UNO", 115200, 32256),
        BoardType("nano", "arduino:avr:nano", "eightanaloginputs", "ARDUINO_AVR_NANO", 115200, 30720),
        BoardType(
            "nano-old", "arduino:avr:nano:cpu=atmega328old", "eightanaloginputs", "ARDUINO_AVR_NANO", 57600, 30720
        ),
    )
}


SKETCH = "robotcore_bridge"
SKETCH_FOLDERS = (Path(__file__).parent / SKETCH, Path(__file__).parents[3] / "firmware" / SKETCH)
"""The folders in which the sketch may be: in an installed robotcore, and in a clone of the project."""


def shipped_sketch() -> Path:
    """Return the folder of the sketch that this robotcore contains."""
    return next(place for place in SKETCH_FOLDERS if (place / f"{SKETCH}.ino").is_file())


def find_sketch(folder: Path | None) -> Path:
    """Return the folder of a sketch.

    folder: the folder of a sketch, or the folder that was passed to `copy_sketch`. None means this robotcore's own
        sketch.
    Raises UsageError if the folder has no sketch, which Arduino expects as FOLDER/FOLDER.ino.
    """
    if folder is None:
        return shipped_sketch()
    for place in (folder.absolute(), folder.absolute() / SKETCH):
        if (place / f"{place.name}.ino").is_file():
            return place
    raise UsageError(
        f"{folder}: there is no sketch {folder.name}.ino. `robotcore firmware copy DIR` makes one to edit",
        kind="sketch-missing",
        folder=str(folder),
    )


def read_baud(folder: Path) -> int:
    """Return the baud rate in a sketch's config.h; 57600 if there is none."""
    header = folder / "config.h"
    found = re.search(r"(?m)^#define BAUD (\d+)", header.read_text()) if header.is_file() else None
    return int(found[1]) if found else 57600


def copy_sketch(into: Path) -> Path:
    """Copy the sketch of this robotcore into a folder, and return the folder of the copy.

    A user can edit the pins in the copy's config.h. Raises UsageError if there is a copy already, or the folder cannot
    be written.
    """
    target = into / SKETCH
    try:
        shutil.copytree(shipped_sketch(), target)
    except FileExistsError as error:
        raise UsageError(
            f"{target}: exists already. Edit its config.h, or name another folder",
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
"""The patterns of port names: of an Uno, and of the USB converter on a Nano."""


def find_only_port(devices: Path = DEVICE_FOLDER) -> str:
    """Return the only USB serial port; raises UsageError if there is none, or several."""
    ports = sorted(str(port) for pattern in PORT_PATTERNS for port in devices.glob(pattern))
    if len(ports) == 1:
        return ports[0]
    if ports:
        raise UsageError(
            f"several boards are plugged in: {', '.join(ports)}. Name the port, such as --port {ports[0]}",
            kind="port-ambiguous",
            ports=ports,
        )
    raise UsageError(
        "no board is plugged in: there is no /dev/ttyACM* or /dev/ttyUSB*. Plug it in, or name its --port",
        kind="no-board",
    )


def require_free(port: str) -> None:
    """Raise FirmwareError if the port does not exist, this user may not use it, or another process has it open."""
    if not Path(port).is_char_device():
        raise FirmwareError(
            f"{port}: is no port. Plug the board in; `ls /dev/serial/by-id` lists the ports",
            kind="port-missing",
            port=port,
        )
    if not os.access(port, os.R_OK | os.W_OK):
        raise FirmwareError(
            f"{port}: you have no permission. sudo usermod -aG dialout $USER, then log in again",
            kind="port-permission",
            port=port,
        )
    if holders := describe_holders(port):
        raise FirmwareError(
            f"{port}: is held by {holders}. End that program first: flashing would disturb it",
            kind="port-in-use",
            port=port,
            holders=holders,
        )


QUESTION, ANSWER = b"v\r", b"robotcore-bridge "
BOOTING_S, BETWEEN_S, TIMES = 2.0, 0.5, 6
"""The pause after opening the port in seconds, the time between two questions in seconds, and the number of questions.
Opening resets the board, and bytes during the pause would keep the board in its bootloader."""


def read_version(port: str, baud: int) -> str:
    """Ask the board at a port for its firmware's version, and return the answer, such as ``robotcore-bridge 1``.

    Raises FirmwareError if robotcore_bridge does not answer within `TIMES` questions, or the port cannot be opened.
    """
    clock = MonotonicClock()
    try:
        with _open_port(port, baud) as port_file:
            clock.sleep_until(BOOTING_S)
            heard = b"".join(_read_answers(port_file, clock))
    except (OSError, termios.error) as error:
        raise FirmwareError(
            f"{port}: the version of the firmware cannot be read: {error}", kind="port-unusable", port=port
        ) from error
    for line in heard.splitlines():
        if ANSWER in line:
            return line[line.index(ANSWER) :].decode("ascii", "replace")
    said = repr(heard.splitlines()[-1][:60]) if heard else "nothing"
    raise FirmwareError(
        f"{port}: the board was flashed, but answered {said} to the question for its version at {baud} baud. "
        "Press its reset button, and check --board and the BAUD of config.h",
        kind="wrong-firmware",
        port=port,
        baud=baud,
    )


@contextmanager
def _open_port(port: str, baud: int) -> Iterator[int]:
    if (speed := getattr(termios, f"B{baud}", None)) is None:
        raise OSError(EINVAL, f"a terminal cannot be set to {baud} baud")
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
    """Send the question for the version until the answer is complete; yield the bytes as they arrive."""
    heard = b""
    for _ in range(TIMES):
        os.write(line, QUESTION)
        end = clock.now() + BETWEEN_S
        while (left := end - clock.now()) > 0 and select.select([line], [], [], left)[0]:
            if not (some := os.read(line, 256)):
                raise OSError(EIO, "the port is lost")
            heard += some
            yield some
            if ANSWER in heard and heard.endswith(b"\n"):
                return

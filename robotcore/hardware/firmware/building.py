"""Building the sketch with whichever tool is here."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from robotcore.errors import FirmwareError
from robotcore.hardware.firmware import arduino_cli, avr_gcc
from robotcore.hardware.firmware.boards import Board


@dataclass(frozen=True)
class Built:
    """A program for a board, in Intel's hexadecimal format, and the tool that made it."""

    image: Path
    tool: str
    size_bytes: int


def build(sketch: Path, board: Board, folder: Path) -> Built:
    """Build a sketch into a folder: with arduino-cli, else with avr-gcc and Debian's Arduino core.

    Raises FirmwareError where neither is here, with what to install; where the sketch does not compile, with what the
    compiler said; where it is too big for the board.
    """
    if arduino_cli.is_here() and arduino_cli.has_core():
        tool, image = arduino_cli.TOOL, arduino_cli.build(sketch, board, folder)
    elif avr_gcc.is_here():
        tool, image = avr_gcc.TOOL, avr_gcc.build(sketch, board, folder)
    else:
        raise FirmwareError(f"nothing here builds for a {board.name}. {_remedy()}")
    return Built(image, tool, _fitting(image, board))


def _remedy() -> str:
    core = "arduino-cli core install arduino:avr"
    if arduino_cli.is_here():
        return f"arduino-cli lacks the core of the board: {core}"
    debian = f"on Debian or Raspberry Pi OS: sudo apt install {avr_gcc.DEBIAN_PACKAGES}"
    return f"Install arduino-cli ({arduino_cli.URL}) and then: {core}; or, {debian}"


def _fitting(image: Path, board: Board) -> int:
    """Return how many bytes of flash an image takes; raises FirmwareError where the board has fewer."""
    size = sum(int(line[1:3], 16) for line in image.read_text().splitlines() if line[7:9] == "00")
    if size > board.flash_bytes:
        raise FirmwareError(f"{image}: has {size} bytes, and a {board.name} takes {board.flash_bytes}. Make it smaller")
    return size

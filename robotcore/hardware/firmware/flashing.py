"""Putting a program on a board, by its bootloader."""

from __future__ import annotations

from pathlib import Path

from robotcore.errors import FirmwareError
from robotcore.hardware.firmware import arduino_cli
from robotcore.hardware.firmware.boards import Board
from robotcore.hardware.firmware.tools import found, run

AVRDUDE = "avrdude"
REMEDY = "A board that does not respond may have the other bootloader: try --board nano-old, or nano, or uno"


def flash(image: Path, board: Board, port: str) -> str:
    """Write an image to the board at a port, and read it back; return the tool that did.

    Raises FirmwareError with what the tool said, or what to install where there is none.
    """
    if found(AVRDUDE):
        run(_avrdude(image, board, port), f"flashing the {board.name} at {port}", REMEDY)
        return AVRDUDE
    if arduino_cli.is_here():
        arduino_cli.flash(image, board, port)
        return arduino_cli.TOOL
    raise FirmwareError(
        f"nothing here flashes a {board.name}. On Debian or Raspberry Pi OS: sudo apt install {AVRDUDE}"
    )


def _avrdude(image: Path, board: Board, port: str) -> list[str]:
    """Source: avrdude(1), and the upload pattern of the Arduino core's platform.txt."""
    chip = ["-p", "m328p", "-c", "arduino", "-P", port, "-b", str(board.upload_baud)]
    return [AVRDUDE, "-q", *chip, "-D", "-U", f"flash:w:{image}:i"]

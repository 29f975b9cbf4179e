"""Building and flashing by arduino-cli.

Source of its command line: https://arduino.github.io/arduino-cli/latest/commands/, of the release 0.13 and later.
"""

from __future__ import annotations

from pathlib import Path

from robotcore.hardware.firmware.boards import Board
from robotcore.hardware.firmware.tools import found, run

TOOL = "arduino-cli"
URL = "https://arduino.github.io/arduino-cli"
CORE = "arduino:avr"


def is_here() -> bool:
    """Return whether it is installed."""
    return found(TOOL)


def has_core() -> bool:
    """Return whether it has the core of our boards; raises FirmwareError where it cannot say."""
    listed = run([TOOL, "core", "list"], "asking for its cores")
    return any(line.split()[:1] == [CORE] for line in listed.splitlines())


def build(sketch: Path, board: Board, folder: Path) -> Path:
    """Compile a sketch into a folder; return the image. Raises FirmwareError with what the compiler said."""
    folder.mkdir(parents=True, exist_ok=True)
    run([TOOL, "compile", "--fqbn", board.fqbn, "--output-dir", folder, sketch], f"building {sketch.name}")
    return folder / f"{sketch.name}.ino.hex"


def flash(image: Path, board: Board, port: str) -> None:
    """Put an image on the board at a port; raises FirmwareError with what it said."""
    where = ["--fqbn", board.fqbn, "--port", port, "--verify"]
    run([TOOL, "upload", *where, "--input-file", image], f"flashing the {board.name} at {port}")

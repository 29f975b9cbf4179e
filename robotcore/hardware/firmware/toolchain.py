"""Builds the firmware and writes it to a board, with arduino-cli, version 0.13 or later.

Source of its commands: https://arduino.github.io/arduino-cli/latest/commands/.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from robotcore.errors import FirmwareError
from robotcore.hardware.firmware.board import BOARDS

ARDUINO_CLI = "arduino-cli"
INSTALL = "Install arduino-cli (https://arduino.github.io/arduino-cli/latest/installation)"
CORE = "arduino:avr"
FLASH_REMEDY = "The board may be of another type or have another bootloader. Try --board nano-old, nano and uno"


def build(sketch: Path, board: str, folder: Path) -> tuple[Path, str]:
    """Build a sketch, and return the image and the output of the compiler.

    sketch: the folder of the sketch.
    board: the type of the board, a key of `BOARDS`.
    folder: the folder for the image.

    Raises FirmwareError if arduino-cli or its core of these boards is not installed, or if the sketch does not compile
    or is too large for the board.
    """
    install_core = f"{ARDUINO_CLI} core install {CORE}"
    if not shutil.which(ARDUINO_CLI):
        problem, remedy = f"{ARDUINO_CLI} is not installed", f"{INSTALL}, and then its core: {install_core}"
    elif not _has_core():
        problem, remedy = f"{ARDUINO_CLI} has no core for the board {board}", f"Install it: {install_core}"
    else:
        folder.mkdir(parents=True, exist_ok=True)
        command: list[str | Path] = [ARDUINO_CLI, "compile", "--fqbn", BOARDS[board], "--output-dir", folder, sketch]
        output = run_tool(command, f"building {sketch.name}")
        return folder / f"{sketch.name}.ino.hex", output
    raise FirmwareError(f"{problem}. {remedy}", kind="no-build-tool", board=board)


def _has_core() -> bool:
    listed = run_tool([ARDUINO_CLI, "core", "list"], "listing the installed cores")
    return any(line.split()[:1] == [CORE] for line in listed.splitlines())


def flash(image: Path, board: str, port: str) -> None:
    """Write an image to the board at a port, and verify it. Raises FirmwareError if arduino-cli fails."""
    command = [ARDUINO_CLI, "upload", "--fqbn", BOARDS[board], "--port", port, "--verify", "--input-file", str(image)]
    run_tool(command, f"flashing the {board} at {port}", FLASH_REMEDY)


def run_tool(command: Sequence[str | Path], activity: str, remedy: str = "", timeout: float = 300.0) -> str:
    """Run a tool until it ends, and return its output on stdout and stderr.

    activity: the task of the tool, for error messages, such as ``building robotcore_bridge``.
    remedy: a sentence for the error message if the tool fails.
    timeout: the time limit in seconds.

    Raises FirmwareError if the tool fails, does not end in time, or cannot be run.
    """
    tool = Path(command[0]).name
    try:
        ran = subprocess.run(  # noqa: S603  a known tool, without a shell
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FirmwareError(
            f"{activity}: {tool} did not end within {timeout:g} s and was killed",
            kind="tool-timeout",
            tool=tool,
            timeout_s=timeout,
        ) from error
    except OSError as error:
        raise FirmwareError(
            f"{activity}: {tool} cannot be run: {error.strerror}", kind="tool-missing", tool=tool
        ) from error
    if ran.returncode:
        output = ran.stdout.strip() or "nothing"
        advice = f". {remedy}" if remedy else ""
        raise FirmwareError(
            f"{activity}: {tool} failed (exit {ran.returncode}){advice}. Its output:\n{output}",
            kind="tool-failed",
            tool=tool,
            status=ran.returncode,
        )
    return ran.stdout

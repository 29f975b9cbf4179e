"""``robotcore firmware`` compiles the program for an Arduino that drives the wheels, and flashes the board."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import click

from robotcore.cli.output import write_line

_BOARDS = ("uno", "nano", "nano-old")

_board = click.option(
    "--board",
    "name",
    type=click.Choice(_BOARDS),
    default="uno",
    show_default=True,
    help="nano-old is a Nano with the bootloader from before 2018. Most clones have it.",
)
_sketch = click.option(
    "--sketch-dir",
    "folder",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    help="Your own copy of the sketch, with your robot's config.h. Default: the sketch of robotcore.",
)


@click.group("firmware")
def command() -> None:
    """Put robotcore's program on an Arduino that drives wheels."""


@command.command("copy")
@click.argument("into", metavar="DIR", type=click.Path(path_type=Path, file_okay=False))
def copy(into: Path) -> None:
    """Copy the sketch into DIR, so that you can write your robot's pins into its config.h."""
    from robotcore.hardware.firmware.board import copy_sketch

    target = copy_sketch(into)
    write_line(f"Write the pins of your robot into {target / 'config.h'}")
    write_line(f"Then flash the board: robotcore firmware flash --sketch-dir {target}")


@command.command("build")
@_board
@_sketch
@click.option(
    "--into",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("build/firmware"),
    show_default=True,
    help="The folder for the compiled program.",
)
def build(name: str, folder: Path | None, into: Path) -> None:
    """Compile the sketch with arduino-cli."""
    from robotcore.hardware.firmware.board import find_sketch

    write_line(str(_build(find_sketch(folder), name, into)))


@command.command("flash")
@_board
@_sketch
@click.option("--port", help="The board's port, such as /dev/ttyUSB0. Not needed if only one board is plugged in.")
def flash(name: str, folder: Path | None, port: str | None) -> None:
    """Compile the sketch, flash the board, and ask the board for its version."""
    from robotcore.hardware.firmware import board
    from robotcore.hardware.firmware.toolchain import flash as write_image

    board.require_terminals()
    port = port or board.find_only_port()
    board.require_free(port)
    folder = board.find_sketch(folder)
    with TemporaryDirectory(prefix="robotcore-firmware-") as scratch:
        image = _build(folder, name, Path(scratch))
        write_line(f"flashing the {name} at {port} ...")
        write_image(image, name, port)
    write_line("flashed and verified")
    write_line(f"{port} answers: {board.read_version(port, board.read_baud(folder))}")


def _build(folder: Path, board: str, into: Path) -> Path:
    from robotcore.hardware.firmware.toolchain import build

    image, output = build(folder, board, into.absolute())
    write_line(output.strip())
    return image

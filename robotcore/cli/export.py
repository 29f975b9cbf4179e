"""``robotcore export``: a robot, and a world around it, for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.output import write_content, write_line
from robotcore.cli.output_files import require_apart
from robotcore.errors import UsageError
from robotcore.files import replace_file

if TYPE_CHECKING:
    from robotcore.hal.backend import Exported


@click.command("export")
@click.argument("robot")
@click.option("--format", "file_format", default="urdf", show_default=True, help="urdf, or mjcf: MuJoCo's own.")
@click.option("--world", help="A world's name, or its .toml file: the robot stands at its start.")
@click.option("--seed", type=int, help="Draw the world anew from this number.")
@click.option("--output", metavar="FILE", type=click.Path(path_type=Path), help="Where to; stdout if left out.")
def command(robot: str, file_format: str, world: str | None, seed: int | None, output: Path | None) -> None:
    """Write a robot for other tools, as URDF or MJCF.

    ROBOT is a name or a .toml file. What is written is what is simulated. The patterns of a world are pictures in the
    folder FILE_textures beside the file, FILE without its ending; on stdout they are left out.
    """
    from robotcore.description import is_own, load_robot
    from robotcore.simulation.export import export_model, prepare_world

    require_apart("--output", output, *(name for name in (robot, world) if name and is_own(name)))
    described, around = load_robot(robot), None
    if world is not None:
        described, around = prepare_world(described, world, seed)
    elif seed is not None:
        raise UsageError("--seed draws a world, and there is none. Name one, for example --world arena")
    model = export_model(file_format, described, around, _folder_of(output) if output else None)
    _write(model, output)
    for note in model.notes:
        write_line(f"note: {note}", is_error=True)


def _folder_of(output: Path) -> str:
    """Return the name of the folder for the pictures; what of a file's name is no Unicode can be in no XML."""
    return f"{output.stem}_textures".encode(errors="ignore").decode()


def _write(model: Exported, output: Path | None) -> None:
    """Write the pictures, then the model: where that is there, so is all that it names."""
    if output is None:
        write_content(model.text)
        return
    for name, picture in model.pictures.items():
        _write_file(output.parent / name, picture, is_beside=True)
    _write_file(output, model.text.encode())


def _write_file(file: Path, content: bytes, *, is_beside: bool = False) -> None:
    try:
        if is_beside:
            file.parent.mkdir(exist_ok=True)
        with replace_file(file) as part:
            part.write_bytes(content)
    except OSError as error:
        remedy = "Name a file that can be written, where there is room"
        raise UsageError(f"{error.filename or file}: {error.strerror}. {remedy}") from error

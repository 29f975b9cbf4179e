"""Commands on descriptions: ``check`` validates a robot or a world, ``export`` writes them for other tools."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.options import pair
from robotcore.cli.output import write_content, write_finding, write_line
from robotcore.cli.output_files import require_apart
from robotcore.errors import UsageError
from robotcore.files import replace_file
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.description import RobotDescription, WorldDescription
    from robotcore.hal.backend import ModelExport

_OPTIONAL_SECTIONS = ("conditions", "randomisation")
"""The sections that most descriptions of worlds do not have."""


@click.command("check")
@click.argument("file")
@click.option("--backend", help="Look for the robot's devices in the scene that this simulator has open.")
@click.option("--host", help="Short for --option host=…")
@click.option("--port", help="Short for --option port=…")
@click.option("--option", "options", metavar="KEY=VALUE", type=pair, multiple=True, help="An option of the backend.")
def check(
    file: str, backend: str | None, host: str | None, port: str | None, options: tuple[tuple[str, str], ...]
) -> int:
    """Check a robot or a world FILE.

    FILE is a file or a name. Prints a summary, or all faults of the file with a remedy each. A backend's own section,
    such as the wiring, is checked by that backend. The exit status is 3 if that backend cannot be imported.

    With --backend, also looks for each device in the open scene. The exit status is 1 if one is missing there, and 3
    if the simulator does not answer.
    """
    from robotcore.description import RobotDescription, load_any

    chosen_options = {
        **dict(options),
        **{key: value for key, value in (("host", host), ("port", port)) if value is not None},
    }
    if chosen_options and backend is None:
        raise UsageError(
            f"option {next(iter(chosen_options))} needs a backend. Name it with --backend",
            kind="option-without-effect",
        )
    description = load_any(file)
    if isinstance(description, RobotDescription):
        if backend:
            return _inspect_scene(file, description, backend, chosen_options)
        return _check_robot(file, description)
    if backend:
        raise UsageError(
            f"{file} describes a world; --backend looks for the devices of a robot. Leave --backend out",
            kind="option-without-effect",
        )
    write_line(f"{file}: OK, {_format_world(description)}")
    return 0


def _check_robot(file: str, robot: RobotDescription) -> int:
    """Print a summary of a robot, and the check of each of its backend sections. Return the exit status."""
    from robotcore.errors import BackendMissingError

    results = [([f"OK, {_format_robot(robot)}"], ""), *(_check_section(robot, section) for section in robot.backends)]
    for line in (line for lines, _ in results for line in lines):
        write_line(f"{file}: {line}")
    if unchecked := [f"{file}: {why}" for _, why in results if why]:
        raise BackendMissingError("\n".join(unchecked), kind="section-unchecked")
    return 0


def _inspect_scene(file: str, robot: RobotDescription, name: str, options: Mapping[str, str]) -> int:
    """Print which devices of a robot are in the open scene of a simulator. Return the exit status."""
    from robotcore.hal.backend import Setup, load_backend
    from robotcore.hal.check_finding import Level

    backend = load_backend(name)
    backend.require_installed()
    devices = frozenset(device.name for device in robot.devices)
    status = 0
    write_line(f"{file}: OK, {_format_robot(robot)}")
    for finding in backend.inspect_scene(Setup(robot, None, devices, options=options)):
        write_finding(finding)
        status = 1 if finding.level is Level.ERROR else status
    return status


def _check_section(robot: RobotDescription, section: str) -> tuple[list[str], str]:
    """Check the section of a backend in a robot's file.

    Return the lines to print, and the reason if the backend cannot check the section.
    """
    from robotcore.errors import BackendMissingError
    from robotcore.hal.backend import load_backend

    try:
        backend = load_backend(section)
        summary, warnings = backend.check(robot), [f"[{section}] warning: {each}" for each in backend.warnings(robot)]
    except BackendMissingError as error:
        return [], f"[{section}] was not checked: {error}"
    line = f"[{section}] OK, {summary}" if summary else f"[{section}] was not checked: the backend reads no section"
    return [line, *warnings], ""


def _format_robot(robot: RobotDescription) -> str:
    kinds = Counter(device.kind.replace("_", " ") for device in robot.devices)
    devices = ", ".join(pluralize(number, kind) for kind, number in kinds.items()) or "no devices"
    return f"the robot {robot.name!r}: {devices}"


def _format_world(world: WorldDescription) -> str:
    without = "" if world.targets else " (nothing to search for)"
    counts = f"{pluralize(len(world.obstacles), 'obstacle')}, {pluralize(len(world.targets), 'target')}{without}"
    own = "".join(f", {section} of its own" for section in _OPTIONAL_SECTIONS if section in world.model_fields_set)
    return f"the world {world.name!r}: {world.floor.length_m:g} m x {world.floor.width_m:g} m, {counts}{own}"


@click.command("export")
@click.argument("robot")
@click.option("--format", "file_format", default="urdf", show_default=True, help="urdf, or mjcf for MuJoCo.")
@click.option("--world", help="A world's name, or its .toml file. The robot stands at the start of the world.")
@click.option("--seed", type=int, help="The seed of the world's random variations.")
@click.option("--output", metavar="FILE", type=click.Path(path_type=Path), help="The file to write; default: stdout.")
def export(robot: str, file_format: str, world: str | None, seed: int | None, output: Path | None) -> None:
    """Write a robot for other tools, as URDF or MJCF.

    ROBOT is a name or a .toml file. Writes the same model that is simulated. Textures of a world are written as
    pictures into the folder FILE_textures beside the file, where FILE is its name without the suffix. On stdout they
    are left out.
    """
    from robotcore.description import is_own, load_robot
    from robotcore.simulation.export import export_model, prepare_world

    require_apart("--output", output, *(name for name in (robot, world) if name and is_own(name)))
    robot_description, world_description = load_robot(robot), None
    if world is not None:
        robot_description, world_description = prepare_world(robot_description, world, seed)
    elif seed is not None:
        raise UsageError(
            "--seed draws a world, and none is named. Name one, for example --world arena",
            kind="option-without-effect",
        )
    folder = _name_texture_folder(output) if output else None
    model = export_model(file_format, robot_description, world_description, folder)
    _write_model(model, output)
    for note in model.notes:
        write_line(f"note: {note}", is_error=True)


def _name_texture_folder(output: Path) -> str:
    """Return the name of the folder for textures. Bytes that are not Unicode are left out, because XML forbids them."""
    return f"{output.stem}_textures".encode(errors="ignore").decode()


def _write_model(model: ModelExport, output: Path | None) -> None:
    """Write the pictures, then the model. If the model exists, all its pictures exist too."""
    if output is None:
        write_content(model.text)
        return
    for name, picture in model.pictures.items():
        _write_file(output.parent / name, picture, makes_folder=True)
    _write_file(output, model.text.encode())


def _write_file(file: Path, content: bytes, *, makes_folder: bool = False) -> None:
    try:
        if makes_folder:
            file.parent.mkdir(exist_ok=True)
        with replace_file(file) as part:
            part.write_bytes(content)
    except OSError as error:
        remedy = "Name a file that can be written, where there is room"
        name = error.filename or file
        raise UsageError(f"{name}: {error.strerror}. {remedy}", kind="file-not-writable", file=str(name)) from error

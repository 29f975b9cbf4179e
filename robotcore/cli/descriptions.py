"""Commands on descriptions: ``check`` validates a robot or a world, ``export`` converts a robot for other tools."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.options import backend_option, host_option, merge_options, port_option, refuse_without
from robotcore.cli.output import write_content, write_finding, write_line
from robotcore.cli.output_files import require_no_input
from robotcore.errors import UsageError
from robotcore.files import replace_file
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.description import RobotDescription, WorldDescription
    from robotcore.hal.backend import ModelExport

_OPTIONAL_SECTIONS = ("conditions", "randomisation")
"""The sections of a world that `check` mentions if the world has them."""


@click.command("check")
@click.argument("file")
@click.option("--backend", help="Look for the robot's devices in the open scene of this simulator.")
@host_option
@port_option
@backend_option
def check(
    file: str, backend: str | None, host: str | None, port: str | None, options: tuple[tuple[str, str], ...]
) -> int:
    """Check the FILE of a robot or a world.

    FILE is a .toml file or a name. Prints a summary, or each problem of the file with its remedy. A section for a
    backend, such as the wiring, is checked by that backend. The exit status is 3 if that backend cannot be imported.

    With --backend, also looks for each device of the robot in the open scene. The exit status is 1 if a device is
    missing, and 3 if the simulator does not answer.
    """
    from robotcore.description import RobotDescription, load_any

    if backend is None:
        given = {"host": host is not None, "port": port is not None, "option": bool(options)}
        refuse_without("--backend", "Add the simulator, such as --backend coppeliasim", **given)
    description = load_any(file)
    if isinstance(description, RobotDescription):
        if backend:
            return _inspect_scene(file, description, backend, merge_options(options, host=host, port=port))
        return _check_robot(file, description)
    refuse_without("a robot", f"{file} describes a world. Leave the option out", backend=backend is not None)
    from robotcore.description.doubtful_values import find_bodies_outside

    for line in (
        f"OK, {_format_world(description)}",
        *(f"warning: {each}" for each in find_bodies_outside(description)),
    ):
        write_line(f"{file}: {line}")
    return 0


def _check_robot(file: str, robot: RobotDescription) -> int:
    from robotcore.description.doubtful_values import find_doubtful_values
    from robotcore.errors import BackendMissingError

    doubts = [f"warning: {each}" for each in find_doubtful_values(robot)]
    results = [
        ([f"OK, {_format_robot(robot)}", *doubts], ""),
        *(_check_section(robot, section) for section in robot.backends),
    ]
    for line in (line for lines, _ in results for line in lines):
        write_line(f"{file}: {line}")
    if unchecked := [f"{file}: {why}" for _, why in results if why]:
        raise BackendMissingError("\n".join(unchecked), kind="section-unchecked")
    return 0


def _inspect_scene(file: str, robot: RobotDescription, name: str, options: Mapping[str, str]) -> int:
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
    """Check a backend's section in a robot's file.

    Return the lines to print. If the backend cannot check the section, return no lines and the reason.
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

    ROBOT is a name or a .toml file. Writes the model that robotcore simulates. With --output NAME.xml, writes the
    textures of the world as pictures into the folder NAME_textures beside that file. Without --output, leaves the
    textures out.
    """
    from robotcore.description import is_own, load_robot
    from robotcore.simulation.export import export_model, prepare_world

    require_no_input("--output", output, *(name for name in (robot, world) if name and is_own(name)))
    robot_description, world_description = load_robot(robot), None
    if world is not None:
        robot_description, world_description = prepare_world(robot_description, world, seed)
    else:
        refuse_without("a world", "Add one, for example --world arena", seed=seed is not None)
    folder = _name_texture_folder(output) if output else None
    model = export_model(file_format, robot_description, world_description, folder)
    _write_model(model, output)
    for note in model.notes:
        write_line(f"note: {note}", is_error=True)


def _name_texture_folder(output: Path) -> str:
    """Return the name of the folder for textures, without bytes that are not Unicode, because XML forbids them."""
    return f"{output.stem}_textures".encode(errors="ignore").decode()


def _write_model(model: ModelExport, output: Path | None) -> None:
    """Write the pictures before the model, so that an existing model has all its pictures."""
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
        remedy = "Name a file that you can write, on a disk with free space"
        name = error.filename or file
        raise UsageError(f"{name}: {error.strerror}. {remedy}", kind="file-not-writable", file=str(name)) from error

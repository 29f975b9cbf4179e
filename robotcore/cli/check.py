"""``robotcore check``: whether a robot or a world is described right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

from robotcore.cli.options import pair
from robotcore.cli.output import write_finding, write_line
from robotcore.errors import UsageError
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.description import RobotDescription, WorldDescription

SECTIONS = ("conditions", "randomisation")
"""Of a world, those that it mostly does without."""


@click.command("check")
@click.argument("file")
@click.option("--backend", help="Look whether a robot's devices are in the scene that this simulator has open.")
@click.option("--host", help="Short for --option host=…")
@click.option("--port", help="Short for --option port=…")
@click.option("--option", "options", metavar="KEY=VALUE", type=pair, multiple=True, help="An option of the backend.")
def command(
    file: str, backend: str | None, host: str | None, port: str | None, options: tuple[tuple[str, str], ...]
) -> int:
    """Check a robot or a world FILE.

    Says what it describes, or all that is wrong with it and what would be right. A name will do too. What a robot's
    file has for a single backend, such as its wiring, is checked by that backend; where that cannot be, for a package
    is broken, the exit status is 3. With --backend, the simulator that runs is asked: 1 where something is missing in
    its scene, 3 where nobody answers.
    """
    from robotcore.description import RobotDescription, load_any

    chosen_options = {
        **dict(options),
        **{key: value for key, value in (("host", host), ("port", port)) if value is not None},
    }
    if chosen_options and backend is None:
        raise UsageError(f"option {next(iter(chosen_options))}: of which backend? Name it with --backend")
    described = load_any(file)
    if isinstance(described, RobotDescription):
        return _look(file, described, backend, chosen_options) if backend else _check(file, described)
    if backend:
        raise UsageError(f"{file} describes a world; --backend looks for the devices of a robot. Leave it out")
    write_line(f"{file}: OK, {_world(described)}")
    return 0


def _check(file: str, robot: RobotDescription) -> int:
    """Tell what a robot has, and what each backend says of its own section."""
    from robotcore.errors import BackendMissingError

    checked = [([f"OK, {_robot(robot)}"], ""), *(_checked(robot, section) for section in robot.backends)]
    for line in (line for lines, _ in checked for line in lines):
        write_line(f"{file}: {line}")
    if unchecked := [f"{file}: {why}" for _, why in checked if why]:
        raise BackendMissingError("\n".join(unchecked))
    return 0


def _look(file: str, robot: RobotDescription, name: str, options: Mapping[str, str]) -> int:
    """Tell what of a robot is there in the scene of a simulator that runs."""
    from robotcore.hal.backend import Setup, load_backend
    from robotcore.hal.finding import Level

    backend = load_backend(name)
    backend.require_installed()
    everything = frozenset(device.name for device in robot.devices)
    status = 0
    write_line(f"{file}: OK, {_robot(robot)}")
    for finding in backend.inspect_scene(Setup(robot, None, everything, options=options)):
        write_finding(finding)
        status = 1 if finding.level is Level.ERROR else status
    return status


def _checked(robot: RobotDescription, section: str) -> tuple[list[str], str]:
    """Return what a backend says of its own section, and why it cannot be asked; raises DescriptionError."""
    from robotcore.errors import BackendMissingError
    from robotcore.hal.backend import load_backend

    try:
        backend = load_backend(section)
        has, warnings = backend.check(robot), [f"[{section}] warning: {each}" for each in backend.warnings(robot)]
    except BackendMissingError as error:
        return [], f"[{section}] was not checked: {error}"
    said = f"[{section}] OK, {has}" if has else f"[{section}] was not checked: the backend reads no section"
    return [said, *warnings], ""


def _robot(robot: RobotDescription) -> str:
    kinds = Counter(device.kind.replace("_", " ") for device in robot.devices)
    devices = ", ".join(pluralize(number, kind) for kind, number in kinds.items()) or "no devices"
    return f"the robot {robot.name!r}: {devices}"


def _world(world: WorldDescription) -> str:
    nothing = "" if world.targets else " (nothing to search for)"
    counts = f"{pluralize(len(world.obstacles), 'obstacle')}, {pluralize(len(world.targets), 'target')}{nothing}"
    own = "".join(f", {section} of its own" for section in SECTIONS if section in world.model_fields_set)
    return f"the world {world.name!r}: {world.floor.length_m:g} m x {world.floor.width_m:g} m, {counts}{own}"

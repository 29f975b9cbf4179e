"""``robotcore check``: whether a robot or a world is described right."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from robotcore.description import RobotDescription, WorldDescription

SECTIONS = ("conditions", "randomisation")
"""Of a world, those that it mostly does without."""


@click.command("check")
@click.argument("file")
def command(file: str) -> None:
    """Check a robot or a world FILE.

    Says what it describes, or all that is wrong with it and what would be right. A name will do too. What a robot's
    file has for a single backend, such as its wiring, is checked by that backend; where that cannot be, for a package
    is broken, the exit status is 3.
    """
    from robotcore.description import RobotDescription, load_any
    from robotcore.errors import BackendMissingError

    described = load_any(file)
    if not isinstance(described, RobotDescription):
        click.echo(f"{file}: OK, {_world(described)}")
        return
    checked = [([f"OK, {_robot(described)}"], ""), *(_checked(described, section) for section in described.backends)]
    for line in (line for lines, _ in checked for line in lines):
        click.echo(f"{file}: {line}")
    if unchecked := [f"{file}: {why}" for _, why in checked if why]:
        raise BackendMissingError("\n".join(unchecked))


def _checked(robot: RobotDescription, section: str) -> tuple[list[str], str]:
    """Return what a backend says of its own section, and why it cannot be asked; raises DescriptionError."""
    from robotcore.catalogue import load_backend
    from robotcore.errors import BackendMissingError

    try:
        backend = load_backend(section)
        has, warnings = backend.check(robot), [f"[{section}] warning: {each}" for each in backend.warnings(robot)]
    except BackendMissingError as error:
        return [], f"[{section}] was not checked: {error}"
    said = f"[{section}] OK, {has}" if has else f"[{section}] was not checked: the backend reads no section"
    return [said, *warnings], ""


def _robot(robot: RobotDescription) -> str:
    kinds = Counter(device.kind.replace("_", " ") for device in robot.devices)
    devices = ", ".join(_count(number, kind) for kind, number in kinds.items()) or "no devices"
    return f"the robot {robot.name!r}: {devices}"


def _world(world: WorldDescription) -> str:
    nothing = "" if world.targets else " (nothing to search for)"
    counts = f"{_count(len(world.obstacles), 'obstacle')}, {_count(len(world.targets), 'target')}{nothing}"
    own = "".join(f", {section} of its own" for section in SECTIONS if section in world.model_fields_set)
    return f"the world {world.name!r}: {world.floor.length_m:g} m x {world.floor.width_m:g} m, {counts}{own}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"

"""What of a robot is there in the scene that a simulator has open."""

from __future__ import annotations

from collections.abc import Iterator

from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.finding import Finding
from robotcore.simulation.remote_scene.finding import find
from robotcore.simulation.remote_scene.port import Scene
from robotcore.simulation.remote_scene.section import Placed, places


def look(robot: RobotDescription, section: str, scene: Scene) -> Iterator[Finding]:
    """Yield for each device of the ``section`` the object that it is, or what is wrong; nothing is started or moved.

    Raises DescriptionError where the section is wrong.
    """
    for placed in places(robot, section):
        yield _looked_for(placed, scene)


def _looked_for(placed: Placed, scene: Scene) -> Finding:
    name = placed.told.name
    try:
        thing = find(placed, scene)
    except DeviceError as failure:
        fault, _, remedy = str(failure).removeprefix(f"{name}: ").partition(". ")
        return Finding.error(name, fault, remedy)
    if thing is None:
        return Finding.ok(name, f"none of {', '.join(map(repr, placed.place.path))} is there: kept in memory")
    return Finding.ok(name, f"{thing.path}, a {thing.kind.value}")

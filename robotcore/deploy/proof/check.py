"""The robot and the world as they are described: what ``robotcore check`` says of them."""

from __future__ import annotations

import shlex
from collections.abc import Iterator

from robotcore.deploy.project import Project
from robotcore.deploy.proof.proof import Proof, Say, command_line
from robotcore.description import RobotDescription, load_world
from robotcore.errors import BackendMissingError, DescriptionError, UnprovenError
from robotcore.hal.backend import load_backend
from robotcore.text import escape


def prove(project: Project, say: Say) -> Proof:
    """Return that the descriptions are right, their warnings as notes; raises UnprovenError with all that is wrong."""
    notes: list[str] = []
    for name in filter(None, (project.robot, project.world)):
        say(escape(name))
        try:
            notes += _checked(project, name)
        except DescriptionError as error:
            again = command_line(project, shlex.join(["robotcore", "check", name]))
            raise UnprovenError(f"check: {error}\nRepeat it: {again}") from error
    return Proof(
        "; ".join(f"{escape(name)}: OK" for name in filter(None, (project.robot, project.world))), tuple(notes)
    )


def _checked(project: Project, name: str) -> list[str]:
    if name == project.world:
        load_world(project.at_desk(name))
        return []
    robot = project.described()
    return [note for backend in {*robot.backends, project.backend} for note in _warnings(robot, backend)]


def _warnings(robot: RobotDescription, backend: str) -> Iterator[str]:
    """Yield what a backend warns of in its section; raises DescriptionError where that is wrong, or missing."""
    try:
        loaded = load_backend(backend)
        loaded.check(robot)
        yield from (f"[{backend}] warning: {each}" for each in loaded.warnings(robot))
    except BackendMissingError as error:
        yield f"[{backend}] was not checked: {error}"

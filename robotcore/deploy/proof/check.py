"""The robot and the world as they are described."""

from __future__ import annotations

from robotcore.catalogue import load_backend
from robotcore.deploy.paths import told
from robotcore.deploy.project import Project
from robotcore.deploy.proof.proof import Proof, Say, ask, command_line, told_error
from robotcore.errors import UnprovenError

_WARNING = "] warning: "


def prove(project: Project, say: Say) -> Proof:
    """Return that the descriptions are right, their warnings as notes; raises UnprovenError with all that is wrong."""
    names = [name for name in (project.robot, project.world) if name]
    notes = [note for name in names for note in _checked(project, name, say)]
    load_backend(project.backend).check(project.described())
    return Proof("; ".join(f"{told(name)}: OK" for name in names), tuple(notes))


def _checked(project: Project, name: str, say: Say) -> list[str]:
    """Return the warnings of ``robotcore check``."""
    say(told(name))
    asked = ask(project, "robotcore", ["check", "--", name])
    if asked.returncode:
        again = command_line(project, f"robotcore check {name}")
        raise UnprovenError(f"check: {told_error(asked)}\nRepeat it: {again}")
    return [line for line in asked.stdout.splitlines() if _WARNING in line]

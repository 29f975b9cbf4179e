"""``robotcore new``: a project of one's own, from simulation to the robot; or a package with a backend."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.cli.scaffold import Template


@click.command("new")
@click.argument("folder", metavar="NAME", type=click.Path(path_type=Path))
@click.option("--driver", "is_driver", is_flag=True, help="Make a package that adds a backend, and is tested as one.")
def command(folder: Path, *, is_driver: bool) -> None:
    """Make a project NAME: an app, a robot, a room, their tests.

    It runs, passes its tests and deploys as it is. NAME may be a path, whose last part is the project's name.
    """
    from robotcore.cli.scaffold import DRIVER, PROJECT, make
    from robotcore.runtime.signals import SignalGuard

    template = DRIVER if is_driver else PROJECT
    with SignalGuard():
        make(template, folder)
    for line in _what_next(template, folder):
        write_line(line)


def _what_next(template: Template, folder: Path) -> list[str]:
    """Return what was made, and what to type now."""
    steps = (template.named(step, folder.name) for step in template.first_steps)
    return [
        f"{folder} is made. Begin with",
        f"  cd {shlex.quote(str(folder))}",
        *(f"  {step}" for step in steps),
        "README.md goes on from there.",
    ]

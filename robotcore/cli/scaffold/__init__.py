"""``robotcore new``: create a project or a driver package from a template."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from robotcore.cli.output import write_line
from robotcore.cli.scaffold.template import DRIVER, PROJECT, Template, make, require_free

__all__ = ["DRIVER", "PROJECT", "Template", "make", "new", "require_free"]


@click.command("new")
@click.argument("folder", metavar="NAME", type=click.Path(path_type=Path))
@click.option("--driver", "is_driver", is_flag=True, help="Create a driver package: a backend with its tests.")
def new(folder: Path, *, is_driver: bool) -> None:
    """Create a project NAME with an app, a robot and tests.

    The new project runs, passes its tests and can be deployed without a change. NAME may be a path. Its last part is
    the project's name.
    """
    from robotcore.runtime.signals import SignalGuard

    template = DRIVER if is_driver else PROJECT
    with SignalGuard():
        make(template, folder)
    steps = (template.rename_text(step, folder.name) for step in template.first_steps)
    write_line(f"{folder} has been created. The first commands:")
    write_line(f"  cd {shlex.quote(str(folder))}")
    for step in steps:
        write_line(f"  {step}")
    write_line("README.md explains the next steps.")

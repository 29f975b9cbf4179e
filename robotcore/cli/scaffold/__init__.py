"""``robotcore new``: create a project or a package from a template."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from robotcore.cli.output import write_line
from robotcore.cli.scaffold.template import DRIVER, KIND, PROJECT, Template, make, require_free

__all__ = ["DRIVER", "KIND", "PROJECT", "Template", "make", "new", "require_free"]


@click.command("new")
@click.argument("folder", metavar="NAME", type=click.Path(path_type=Path))
@click.option("--driver", "is_driver", is_flag=True, help="Create a driver package: a backend with its tests.")
@click.option("--kind", "is_kind", is_flag=True, help="Create a package with a kind of device.")
def new(folder: Path, *, is_driver: bool, is_kind: bool) -> None:
    """Create a project NAME with an app, a robot and tests.

    The new project runs, passes its tests and can be deployed without a change. NAME may be a path. Its last part is
    the project's name.
    """
    from robotcore.errors import UsageError
    from robotcore.runtime.signals import SignalGuard

    if is_driver and is_kind:
        text = "--driver and --kind create different packages. Name one of them"
        raise UsageError(text, kind="conflicting-options")
    template = DRIVER if is_driver else KIND if is_kind else PROJECT
    with SignalGuard():
        make(template, folder)
    steps = (template.rename_text(step, folder.name) for step in template.first_steps)
    write_line(f"{folder} has been created. The first commands:")
    write_line(f"  cd {shlex.quote(str(folder))}")
    for step in steps:
        write_line(f"  {step}")
    write_line("README.md explains the next steps.")

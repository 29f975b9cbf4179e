"""``robotcore export``: a robot for other tools."""

from __future__ import annotations

from pathlib import Path

import click

from robotcore.errors import UsageError


@click.command("export")
@click.argument("robot")
@click.option("--output", metavar="FILE", type=click.Path(path_type=Path), help="Where to; stdout if left out.")
def command(robot: str, output: Path | None) -> None:
    """Write ROBOT as URDF; it is a name or a .toml file."""
    from robotcore.description import load_robot
    from robotcore.description.urdf import robot_urdf

    urdf = robot_urdf(load_robot(robot))
    if output is None:
        click.echo(urdf)
        return
    try:
        output.write_text(urdf, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{output}: {error.strerror}. Name a file that can be written") from error

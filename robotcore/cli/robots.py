"""``robotcore robots``: the robots that are shipped."""

from __future__ import annotations

from typing import Any

import click

from robotcore.cli.output import as_json, write_json, write_table


@click.command("robots")
@as_json
def command(*, as_json: bool) -> None:
    """List the robots that --robot knows by name."""
    from robotcore.description import robot_names

    robots = [_robot_row(name) for name in robot_names()]
    if as_json:
        write_json(robots)
    else:
        rows = ((each["name"], "\n".join(each["devices"]), each["summary"]) for each in robots)
        write_table(("robot", "devices", "what it is"), rows)


def _robot_row(name: str) -> dict[str, Any]:
    from robotcore.description import load_robot

    robot = load_robot(name)
    return {
        "name": name,
        "summary": robot.summary,
        "drives": robot.drive is not None,
        "devices": [device.name for device in robot.devices],
    }

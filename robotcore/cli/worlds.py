"""``robotcore worlds``: the worlds that are shipped."""

from __future__ import annotations

from typing import Any

import click

from robotcore.cli.output import as_json, write_json, write_table


@click.command("worlds")
@as_json
def command(*, as_json: bool) -> None:
    """List the worlds that --world knows by name."""
    from robotcore.description import world_names

    worlds = [_world_row(name) for name in world_names()]
    if as_json:
        write_json(worlds)
    else:
        write_table(("world", "floor", "obstacles", "targets", "what it is"), map(_row, worlds))


def _world_row(name: str) -> dict[str, Any]:
    from robotcore.description import load_world

    world = load_world(name)
    return {
        "name": name,
        "summary": world.summary,
        "floor_m": [world.floor.length_m, world.floor.width_m],
        "obstacles": len(world.obstacles),
        "targets": len(world.targets),
        "varies": world.variation is not None,
    }


def _row(world: dict[str, Any]) -> tuple[str, ...]:
    length, width = world["floor_m"]
    floor = f"{length:g} m x {width:g} m"
    return world["name"], floor, str(world["obstacles"]), str(world["targets"]), world["summary"]

"""The command ``fidelity`` compares a recorded run with its simulation by the same commands."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.options import backend_option, host_option, merge_options, parse_seconds, port_option
from robotcore.cli.output import write, write_failure, write_json, write_line
from robotcore.cli.output_files import require_no_input

if TYPE_CHECKING:
    from robotcore.fidelity.fidelity import Fidelity

MISSED = 1
"""The exit status if a measure is above its bound."""


@click.command("fidelity", cls=AnsweringCommand)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--backend", default="kinematic", show_default=True, help="The simulator that repeats the commands.")
@click.option("--robot", metavar="FILE", help="Also simulate the robot of this .toml file, in a second column.")
@click.option("--world", help="The world's name or file. Without it, the recorded world, or else an empty floor.")
@click.option("--duration", metavar="SECONDS", type=parse_seconds, help="Compare only the first SECONDS.")
@click.option(
    "--picture", metavar="FILE", type=click.Path(path_type=Path), help="Draw paths, speeds and ranges as a PNG."
)
@click.option(
    "--require",
    "requirements",
    metavar="BOUND",
    multiple=True,
    help="Require a bound of the last column, such as path.end_m<=0.2. --json has the keys, below as_recorded.",
)
@backend_option
@host_option
@port_option
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")
def command(
    file: Path,
    backend: str,
    robot: str | None,
    world: str | None,
    duration: float | None,
    picture: Path | None,
    requirements: tuple[str, ...],
    options: tuple[tuple[str, str], ...],
    host: str | None,
    port: str | None,
    *,
    as_json: bool,
) -> int:
    """Show how much a simulation differs from a recorded run FILE.

    The simulated robot gets the recorded commands at the recorded times. The command measures the differences of
    the wheel speeds, the paths, the ranges and the pictures.

    Without --robot, the robot is that of the recording. With it, the table has a second column, so that one recording
    shows both the robot's file before a calibration and the file after it.

    Exit status: 0 if all bounds of --require hold, else 1.
    """
    from robotcore.description import load_robot, load_world
    from robotcore.fidelity.bounds import Bound, list_missed_bounds
    from robotcore.fidelity.fidelity import measure_fidelity
    from robotcore.recording import read
    from robotcore.view.page import require_writable

    bounds = [Bound.parse(text) for text in requirements]
    require_no_input("--picture", picture, file, *filter(None, (robot, world)))
    if picture:
        require_writable(picture)
    found = measure_fidelity(
        read(file),
        str(file),
        backend,
        robot=load_robot(robot) if robot else None,
        world=load_world(world) if world else None,
        duration_s=duration,
        options=merge_options(options, host=host, port=port),
    )
    missed = list_missed_bounds(bounds, found.measures)
    status = MISSED if missed else 0
    if as_json:
        write_json(_build_answer(found, missed, status))
    else:
        from robotcore.view.fidelity_table import format_fidelity

        write(format_fidelity(found))
        for problem in missed:
            write_failure(problem)
    if picture:
        from robotcore.canvas import encode_png
        from robotcore.view.fidelity_picture import draw_fidelity
        from robotcore.view.page import save_png

        save_png(encode_png(draw_fidelity(found)), picture)
        write_line(f"The picture: {picture}", is_error=as_json)
    return status


def _build_answer(found: Fidelity, missed: Sequence[str], status: int) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore fidelity``.

    The JSON keys:

    *: robotcore.fidelity.fidelity.Fidelity.to_dict
    missed: list of text; the bounds of ``--require`` that are missed.
    exit_status: whole number; the exit status.
    """
    return {**found.to_dict(), "missed": missed, "exit_status": status}

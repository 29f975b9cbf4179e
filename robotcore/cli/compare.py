"""``robotcore compare``: two recordings side by side."""

from __future__ import annotations

from pathlib import Path

import click

from robotcore.cli.json_answers import AnsweringCommand
from robotcore.cli.output import write, write_json, write_line
from robotcore.cli.output_files import require_apart


@click.command("compare", cls=AnsweringCommand)
@click.argument("first", type=click.Path(path_type=Path))
@click.argument("second", type=click.Path(path_type=Path))
@click.option("--picture", metavar="FILE", type=click.Path(path_type=Path), help="Draw both paths as a PNG.")
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")
def command(first: Path, second: Path, picture: Path | None, *, as_json: bool) -> int:
    """Lay two recordings side by side.

    Their milestones, outcomes, paths and loops, and where they part.

    Exit status: 0 the same milestones in the same order and the same outcome, 1 else.
    """
    from robotcore.recording import read
    from robotcore.recording.comparison import Comparison, RunSummary
    from robotcore.view.comparison import format_comparison
    from robotcore.view.picture import require_writable

    require_apart("--picture", picture, first, second)
    if picture:
        require_writable(picture)
    comparison = Comparison(RunSummary(str(first), read(first)), RunSummary(str(second), read(second)))
    if as_json:
        write_json(comparison.to_dict())
    else:
        write(format_comparison(comparison))
    if picture:
        from robotcore.view.comparison import draw_comparison
        from robotcore.view.picture import encode_png, save_png

        save_png(encode_png(draw_comparison(comparison)), picture)
        write_line(f"The picture: {picture}", is_error=as_json)
    return comparison.exit_status

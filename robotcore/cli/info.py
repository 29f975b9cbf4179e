"""``robotcore info``: what a recording holds, and the same for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.json_answers import AnsweringCommand
from robotcore.cli.output import write, write_json, write_line
from robotcore.cli.output_files import require_apart, require_ending
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.recording import Recording

_FILE = click.Path(path_type=Path)


@click.command("info", cls=AnsweringCommand)
@click.argument("file", type=_FILE)
@click.option("--picture", metavar="FILE", type=_FILE, help="Draw the run, seen from above, as a PNG.")
@click.option("--csv", "table", metavar="FILE_OR_FOLDER", type=_FILE, help="Write a row a tick, for pandas or Excel.")
@click.option("--video", metavar="FILE", type=_FILE, help="Film what was shown, or seen, as an .mp4.")
@click.option("--device", metavar="NAME", help="Film this camera or display.")
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")
def command(
    file: Path, picture: Path | None, table: Path | None, video: Path | None, device: str | None, *, as_json: bool
) -> None:
    """Tell what a recording FILE holds.

    The run, its devices and its end, whether it is whole and can be replayed; and the same as a table or a film.
    """
    from robotcore.recording import read

    if device and not video:
        raise UsageError("--device names whose pictures are filmed. Add --video FILE.mp4")
    _require_outputs(file, picture, table, video)
    recording = read(file)
    if as_json:
        from robotcore.recording.contents import summarise_contents

        write_json({"file": str(file), "bytes": file.stat().st_size, **summarise_contents(recording)})
    else:
        from robotcore.view.text import format_contents

        write(format_contents(recording, file))
    if picture:
        write_line(f"The picture: {_draw(recording, picture)}", is_error=as_json)
    if table:
        write_line(f"The table: {_tabulate(recording, table, file.stem)}", is_error=as_json)
    if video:
        write_line(f"The film: {_film(recording, video, device)}", is_error=as_json)


def _require_outputs(file: Path, picture: Path | None, table: Path | None, video: Path | None) -> None:
    """Raise UsageError where what is asked for would be written over the recording, or under an odd ending."""
    within = table / f"{file.stem}.csv" if table and table.is_dir() else table
    for option, output in (("--picture", picture), ("--csv", within), ("--video", video)):
        require_apart(option, output, file)
    require_ending("--csv", table, (".csv",))
    require_ending("--video", video, (".mp4", ".avi"))


def _draw(recording: Recording, picture: Path) -> Path:
    from robotcore.view.picture import build_figure, draw_png, require_writable, save_png

    require_writable(picture)
    save_png(draw_png(build_figure(recording)), picture)
    return picture


def _tabulate(recording: Recording, where: Path, name: str) -> Path:
    from robotcore.recording.csv_table import write_csv

    return write_csv(recording, where, name)


def _film(recording: Recording, video: Path, device: str | None) -> Path:
    from robotcore.view.video import write_video

    write_video(recording, video, device)
    return video

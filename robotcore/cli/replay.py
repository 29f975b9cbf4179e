"""``robotcore replay``: a recorded run, decided once more."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.json_answers import AnsweringCommand
from robotcore.cli.options import pair
from robotcore.cli.output import redirect_prints, write_json, write_line
from robotcore.cli.output_files import require_apart

if TYPE_CHECKING:
    from robotcore.recording import Recording
    from robotcore.recording.replay import Evaluation, ReplayResult


@click.command("replay", cls=AnsweringCommand)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--app",
    metavar="APP",
    help="The recorded app's own file, also if it has changed; or another app, which then decides on the recorded "
    "samples.",
)
@click.option("--set", "settings", metavar="KEY=VALUE", type=pair, multiple=True, help="Another setting of the app.")
@click.option("--picture", metavar="FILE", type=click.Path(path_type=Path), help="Draw the replay as a PNG.")
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")
def command(
    file: Path, app: str | None, settings: tuple[tuple[str, str], ...], picture: Path | None, *, as_json: bool
) -> int:
    """Replay a recording, up to the first decision that differs.

    An app's file that has changed since runs only if --app names it.

    With another app, or with --set, print what it would have decided on the recorded samples.

    Exit status: 0 all is equal, or another app came to its end; 1 something differs; else as `robotcore run`.
    """
    from robotcore.recording import read
    from robotcore.view.picture import require_writable

    require_apart("--picture", picture, file)
    if picture:
        require_writable(picture)
    recording = read(file)
    with redirect_prints(as_json=as_json):
        came_out = _run(recording, file, app, dict(settings))
    if as_json:
        write_json({"file": str(file), **came_out.to_dict()})
    else:
        _tell(came_out)
    if picture:
        _draw(recording, came_out, picture)
        write_line(f"The picture: {picture}", is_error=as_json)
    return came_out.exit_status


def _run(recording: Recording, file: Path, app: str | None, settings: dict[str, str]) -> ReplayResult | Evaluation:
    from robotcore.recording.replay import evaluate, is_recorded_file, replay

    is_held = not app or (recording.is_replayable and is_recorded_file(recording, app))
    if settings or not is_held:
        return evaluate(recording, app, settings, file=file)
    return replay(recording, file, app=app)


def _tell(came_out: ReplayResult | Evaluation) -> None:
    from robotcore.cli.output import write, write_error
    from robotcore.errors import DeviationError, Interrupted, RecordingEndedError, RobotcoreError
    from robotcore.view.text import format_replay

    write(format_replay(came_out))
    error = came_out.result.error
    is_reported = isinstance(error, (DeviationError, RecordingEndedError)) or not came_out.exit_status
    if isinstance(error, (RobotcoreError, Interrupted)) and not is_reported:
        write_error(error)


def _draw(recording: Recording, came_out: ReplayResult | Evaluation, picture: Path) -> None:
    from robotcore.recording.replay import Evaluation
    from robotcore.view.picture import build_figure, draw_png, save_png

    is_evaluation = isinstance(came_out, Evaluation)
    save_png(draw_png(build_figure(recording, came_out.states, came_out.result, is_evaluation=is_evaluation)), picture)

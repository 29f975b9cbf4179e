"""Commands on recordings: ``info`` shows one, ``compare`` compares two, ``replay`` runs the recorded app again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.options import parse_pair, refuse_without
from robotcore.cli.output import redirect_prints, write, write_json, write_line
from robotcore.cli.output_files import (
    finish_recording,
    require_distinct_outputs,
    require_junit_file,
    require_no_input,
    require_suffix,
    write_error_suite_on_failure,
    write_junit,
)
from robotcore.errors import Interrupted, RecordingError, UsageError

if TYPE_CHECKING:
    from robotcore.recording import Recording
    from robotcore.recording.recorder import Recorder
    from robotcore.recording.replay import Evaluation, ReplayResult

_FILE = click.Path(path_type=Path)
_as_json = click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")


@click.command("info", cls=AnsweringCommand)
@click.argument("file", type=_FILE)
@click.option("--picture", metavar="FILE", type=_FILE, help="Draw the run, seen from above, as a PNG.")
@click.option("--csv", "table", metavar="FILE_OR_FOLDER", type=_FILE, help="Write one row per tick, for a spreadsheet.")
@click.option("--video", metavar="FILE", type=_FILE, help="Write the pictures of a camera or display as an .mp4.")
@click.option("--device", metavar="NAME", help="The camera or display of --video.")
@_as_json
def info(
    file: Path, picture: Path | None, table: Path | None, video: Path | None, device: str | None, *, as_json: bool
) -> None:
    """Show the content of a recording FILE.

    Shows the run, its devices, its end, and whether the file is complete and can be replayed. Options write the
    recording as a picture, a table or a video.
    """
    from robotcore.recording import read

    if device and not video:
        raise UsageError("--device has no effect without a video. Add --video FILE.mp4", kind="option-without-effect")
    _require_valid_outputs(file, picture, table, video)
    recording = read(file)
    if as_json:
        write_json(_build_info_answer(recording, file))
    else:
        from robotcore.view.text import format_contents

        write(format_contents(recording, file))
    if picture:
        _draw_recording(recording, picture)
        write_line(f"The picture: {picture}", is_error=as_json)
    if table:
        from robotcore.recording.csv_table import write_csv

        write_line(f"The table: {write_csv(recording, table, file.stem)}", is_error=as_json)
    if video:
        from robotcore.view.video import write_video

        write_video(recording, video, device)
        write_line(f"The video: {video}", is_error=as_json)


@click.command("compare", cls=AnsweringCommand)
@click.argument("first", type=_FILE)
@click.argument("second", type=_FILE)
@click.option("--picture", metavar="FILE", type=_FILE, help="Draw both paths, seen from above, as a PNG.")
@_as_json
def compare(first: Path, second: Path, picture: Path | None, *, as_json: bool) -> int:
    """Compare two recordings.

    Shows the milestones, outcome, path and loop rate of each run, and the first difference.

    Exit status: 0 if both runs have the same milestones in the same order and the same outcome, else 1.
    """
    from robotcore.recording import read
    from robotcore.recording.run_comparison import Comparison, RunSummary
    from robotcore.view.comparison_view import format_comparison
    from robotcore.view.page import require_writable

    require_no_input("--picture", picture, first, second)
    if picture:
        require_writable(picture)
    comparison = Comparison(RunSummary(str(first), read(first)), RunSummary(str(second), read(second)))
    if as_json:
        write_json(comparison.to_dict())
    else:
        write(format_comparison(comparison))
    if picture:
        from robotcore.canvas import encode_png
        from robotcore.view.comparison_view import draw_comparison
        from robotcore.view.page import save_png

        save_png(encode_png(draw_comparison(comparison)), picture)
        write_line(f"The picture: {picture}", is_error=as_json)
    return comparison.exit_status


@click.command("replay", cls=AnsweringCommand)
@click.argument("file", type=_FILE)
@click.option(
    "--app",
    metavar="APP",
    help="Run this app on the recorded samples. The file of the recorded app runs even if it has changed.",
)
@click.option(
    "--set", "settings", metavar="KEY=VALUE", type=parse_pair, multiple=True, help="Change a setting of the app."
)
@click.option(
    "--require-equal",
    "must_be_equal",
    is_flag=True,
    help="Fail at a decision that differs, also with another app or with --set, and if the recording is incomplete.",
)
@click.option("--picture", metavar="FILE", type=_FILE, help="Draw the replay, seen from above, as a PNG.")
@click.option(
    "--record",
    metavar="FILE",
    type=_FILE,
    help="Record the replay as an .mcap file, with its logged values and prints.",
)
@click.option("--force", "is_forced", is_flag=True, help="Overwrite an existing recording.")
@click.option("--junit", metavar="FILE.xml", type=_FILE, help="Write the result as JUnit XML, which CI servers read.")
@click.option(
    "--watch",
    metavar="FILE.py",
    help="Like --app FILE.py. Replays again when a .py file in the folder of FILE.py is saved.",
)
@_as_json
def replay(
    file: Path,
    app: str | None,
    settings: tuple[tuple[str, str], ...],
    picture: Path | None,
    record: Path | None,
    junit: Path | None,
    watch: str | None,
    *,
    must_be_equal: bool,
    is_forced: bool,
    as_json: bool,
) -> int:
    """Run the recorded app again and compare its decisions.

    Reports the first decision that differs. If the app's file has changed since the recording, it runs only if --app
    names it.

    With another app or with --set, shows how the decisions on the recorded samples differ. Logged values are shown, and
    not compared. With --watch, Ctrl-C ends the command.

    --junit writes a test case, also if the recording cannot be replayed. --require-equal refuses a recording that is
    cut or damaged.

    Exit status: 0 if all decisions are equal, or if another app ran to its end and --require-equal is not given; 1 if
    a decision differs. An error has the exit status of `robotcore run`.
    """
    if watch:
        outputs = {"--picture": picture, "--record": record, "--junit": junit}
        flags = {"--require-equal": must_be_equal, "--json": as_json}
        return _watch(file, watch, app, settings, outputs, flags, is_forced=is_forced)
    from robotcore.recording import read
    from robotcore.recording.replay import Evaluation, ReplayRecorder
    from robotcore.view.page import require_writable

    for option, output in (("--picture", picture), ("--record", record), ("--junit", junit)):
        require_no_input(option, output, file)
    require_distinct_outputs(picture=picture, record=record, junit=junit)
    require_junit_file(junit)
    _require_recordable(record, is_forced=is_forced)
    if picture:
        require_writable(picture)
    options = [*(f"--app={name}" for name in filter(None, [app])), *(f"--set={key}={value}" for key, value in settings)]
    options += ["--require-equal"] if must_be_equal else []
    line = shlex.join(["robotcore", "replay", *options, str(file)])
    with write_error_suite_on_failure(junit, "replay", str(file), line):
        recording = read(file)
        if must_be_equal:
            _require_complete(recording, file)
        recorder = ReplayRecorder(record, recording) if record else None
        with redirect_prints(as_json=as_json):
            result = _replay(recording, file, app, dict(settings), recorder, must_be_equal=must_be_equal)
    _, recorded = finish_recording(result.result, recorder) if recorder else (None, "")
    if as_json:
        write_json(
            _build_evaluation_answer(file, result)
            if isinstance(result, Evaluation)
            else _build_replay_answer(file, result)
        )
    else:
        _write_replay(result)
    if junit and not isinstance(result.result.error, Interrupted):
        from robotcore.view.replay_suite import build_suite

        write_junit([build_suite(file, line, result)], junit)
        write_line(f"The JUnit file: {junit}", is_error=as_json)
    if picture:
        _draw_replay(recording, result, picture)
        write_line(f"The picture: {picture}", is_error=as_json)
    if recorded:
        write_line(recorded, is_error=as_json)
    return result.exit_status or int(recorder is not None and not recorded)


def _build_info_answer(recording: Recording, file: Path) -> dict[str, Any]:
    """Return the data about a recording for JSON.

    The JSON keys:

    file: text; the file of the recording.
    bytes: whole number, bytes; the size of the file.
    *: robotcore.recording.summary.summarise_contents
    exit_status: whole number; the exit status of the program.
    """
    from robotcore.recording.summary import summarise_contents

    return {"file": str(file), "bytes": file.stat().st_size, **summarise_contents(recording), "exit_status": 0}


def _build_replay_answer(file: Path, result: ReplayResult) -> dict[str, Any]:
    """Return the data about a replay of the recorded app for JSON.

    The JSON keys:

    file: text; the file of the recording.
    *: robotcore.recording.replay.verification.ReplayResult.to_dict
    """
    return {"file": str(file), **result.to_dict()}


def _build_evaluation_answer(file: Path, result: Evaluation) -> dict[str, Any]:
    """Return the data about a replay of another app, or with other settings, for JSON.

    The JSON keys:

    file: text; the file of the recording.
    *: robotcore.recording.replay.evaluation.Evaluation.to_dict
    """
    return {"file": str(file), **result.to_dict()}


def _require_valid_outputs(file: Path, picture: Path | None, table: Path | None, video: Path | None) -> None:
    table_file = table / f"{file.stem}.csv" if table and table.is_dir() else table
    for option, output in (("--picture", picture), ("--csv", table_file), ("--video", video)):
        require_no_input(option, output, file)
    require_suffix("--csv", table, (".csv",))
    require_suffix("--video", video, (".mp4", ".avi"))


def _draw_recording(recording: Recording, picture: Path) -> None:
    from robotcore.view.page import require_writable, save_png
    from robotcore.view.picture import build_figure, draw_png

    require_writable(picture)
    save_png(draw_png(build_figure(recording)), picture)


def _watch(
    file: Path,
    watched: str,
    app: str | None,
    settings: tuple[tuple[str, str], ...],
    outputs: Mapping[str, Path | None],
    flags: Mapping[str, bool],
    *,
    is_forced: bool,
) -> int:
    from robotcore.cli.replay_watch import watch_app

    if app:
        raise UsageError(
            f"--watch {watched} names the app, and so does --app {app}. Leave --app out", kind="app-named-twice"
        )
    arguments = ["replay", f"--app={watched}", *(f"--set={key}={value}" for key, value in settings)]
    arguments += [f"{option}={output}" for option, output in outputs.items() if output]
    arguments += [flag for flag, is_given in flags.items() if is_given]
    first = [*arguments, *(["--force"] if is_forced else []), "--", str(file)]
    later = [*arguments, *(["--force"] if outputs["--record"] else []), "--", str(file)]
    return watch_app(watched, first, later, is_quiet=flags["--json"])


def _require_recordable(file: Path | None, *, is_forced: bool) -> None:
    refuse_without("a recording", "Add --record FILE.mcap", force=is_forced and file is None)
    if file:
        from robotcore.recording.mcap_file import require_recordable

        require_recordable(file, is_forced=is_forced)


def _require_complete(recording: Recording, file: Path) -> None:
    """Raise RecordingError if a part of the recording is missing, so that not all its decisions can be compared."""
    if not (recording.is_cut or recording.is_damaged):
        return
    from robotcore.recording.summary import explain_missing_end

    at = recording.ticks[-1].time if recording.ticks else 0.0
    damage = f"the file is damaged after {at:.1f} s ({recording.damage})" if recording.is_damaged else ""
    why = damage or explain_missing_end(recording) or "the end of the file is missing"
    raise RecordingError(
        file,
        f"{why}, so it cannot show that all decisions are equal",
        "Use another copy of the file, or record the run again",
        kind="recording-incomplete",
        why=why,
    )


def _replay(
    recording: Recording,
    file: Path,
    app: str | None,
    settings: dict[str, str],
    recorder: Recorder | None,
    *,
    must_be_equal: bool,
) -> ReplayResult | Evaluation:
    from robotcore.recording.replay import evaluate, is_recorded_app, replay

    is_same_app = not app or (recording.is_replayable and is_recorded_app(recording, app))
    if settings or not is_same_app:
        return evaluate(recording, app, settings, file=file, recorder=recorder, must_be_equal=must_be_equal)
    return replay(recording, file, app=app, recorder=recorder)


def _write_replay(result: ReplayResult | Evaluation) -> None:
    from robotcore.cli.output import write_error
    from robotcore.errors import DeviationError, RecordingEndedError, RobotcoreError
    from robotcore.view.text import format_replay

    write(format_replay(result))
    error = result.result.error
    is_shown = isinstance(error, (DeviationError, RecordingEndedError)) or not result.exit_status
    if isinstance(error, (RobotcoreError, Interrupted)) and not is_shown:
        write_error(error)


def _draw_replay(recording: Recording, result: ReplayResult | Evaluation, picture: Path) -> None:
    from robotcore.recording.replay import Evaluation
    from robotcore.view.page import save_png
    from robotcore.view.picture import build_figure, draw_png

    is_evaluation = isinstance(result, Evaluation)
    save_png(draw_png(build_figure(recording, result.states, result.result, is_evaluation=is_evaluation)), picture)

"""``robotcore run``: one app, on one backend, to its end."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing, redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.json_answers import RunCommand, prepare_result, write_result
from robotcore.cli.options import run_options, size
from robotcore.cli.output import redirect_prints, write_failure, write_line
from robotcore.cli.output_files import finish_recording, make_recorder
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.deploy.systemd_notify import Notifier
    from robotcore.recording.recorder import Recorder
    from robotcore.runtime.result import RunResult
    from robotcore.runtime.session import Observer
    from robotcore.runtime.signals import SignalGuard
    from robotcore.view.picture import PictureRecorder
    from robotcore.view.progress import Progress


@click.command("run", cls=RunCommand)
@click.argument("app")
@click.option("--backend", default="kinematic", show_default=True, help="What it runs on; see `robotcore backends`.")
@click.option("--world", help="A world's name, or its .toml file. Simulators take arena where it is left out.")
@click.option("--seed", type=int, help="Draw the world anew from this number.")
@run_options
@click.option("--host", help="Short for --option host=…")
@click.option("--port", help="Short for --option port=…")
@click.option(
    "--picture", metavar="FILE", type=click.Path(path_type=Path), help="Draw the run, seen from above, as a PNG."
)
@click.option(
    "--record", metavar="FILE", type=click.Path(path_type=Path), help="Record the run as an .mcap file, for Foxglove."
)
@click.option(
    "--record-jpeg", is_flag=True, help="Record the camera as JPEG: a smaller file, which cannot be replayed."
)
@click.option(
    "--record-limit",
    metavar="SIZE",
    type=size,
    help="End the recording, not the run, when its file has that size: 500MB.",
)
@click.option("--gui", is_flag=True, help="Open the simulator's window, at the pace of real time.")
@click.option("--realtime", is_flag=True, help="Hold simulated time to the pace of real time.")
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON at the end, and nothing else.")
def command(
    picture: Path | None,
    record: Path | None,
    *,
    record_jpeg: bool,
    record_limit: int | None,
    as_json: bool,
    **asked: Any,
) -> int:
    """Run APP on a backend; tell how it ended. In front of a terminal, the space bar is the e-stop.

    Exit status: 0 success, 1 failure, timeout or a success that the simulator does not see, 2 wrong usage, 3 a device
    or backend failed, 4 the safety stage stopped it, 5 the app raised, 128 + the signal's number when interrupted.
    """
    from robotcore.deploy.systemd_notify import Notifier
    from robotcore.runtime.signals import SignalGuard

    with SignalGuard() as interrupts:
        drawer = _drawer(picture)
        recorder = make_recorder(record, dict(asked["options"]), is_jpeg=record_jpeg, limit=record_limit)
        notifier = Notifier.of(os.environ)
        on_forced_exit = _last_words(recorder, notifier, as_json=as_json)
        prepare_result(as_json=as_json)
        with redirect_prints(as_json=as_json):
            result = _run(asked, drawer, recorder, notifier, interrupts, on_forced_exit)
        interrupts.mask()
        made = []
        if picture and drawer:
            result, drawn = _with_picture(result, drawer, picture)
            made += [f"The picture: {drawn}"] if drawn else []
        if recorder:
            result, recorded = finish_recording(result, recorder)
            made += [recorded] if recorded else []
        result = notifier.choose_exit_status(result) if notifier else result
        return _finish(result, made, as_json=as_json)


def _finish(result: RunResult, made: list[str], *, as_json: bool) -> int:
    """Tell how the run ended and what it left; return its exit status, whether or not somebody can hear it."""
    try:
        write_result(result, as_json=as_json)
        for line in made:
            write_line(line, is_error=as_json)
    except BrokenPipeError:
        return result.exit_status or 1
    except OSError as error:
        write_failure(f"the output cannot be written: {error.strerror}")
        return result.exit_status or 1
    return result.exit_status


def _with_picture(result: RunResult, drawer: PictureRecorder, picture: Path) -> tuple[RunResult, Path | None]:
    """Save the picture; return where it is, if a run began, and the result.

    A run whose picture could not be written has not done all that was asked of it.
    """
    try:
        return result, picture if drawer.save(picture) else None
    except UsageError as error:
        write_failure(str(error))
        return replace(result, exit_status=result.exit_status or 1, reason=result.reason or str(error)), None


def _drawer(picture: Path | None) -> PictureRecorder | None:
    """Return what watches the run for its picture; refuse now a file that could not be written then."""
    if picture is None:
        return None
    from robotcore.view.picture import PictureRecorder, require_writable

    require_writable(picture)
    return PictureRecorder()


def _run(
    asked: dict[str, Any],
    drawer: PictureRecorder | None,
    recorder: Recorder | None,
    notifier: Notifier | None,
    interrupts: SignalGuard,
    on_forced_exit: Callable[[RunResult], None],
) -> RunResult:
    from robotcore.cli.estop_key import EmergencyStopKey, can_listen
    from robotcore.runtime.session import RunRequest, run

    with ExitStack() as stack:
        in_terminal: list[EmergencyStopKey | Progress] = []
        bar = stack.enter_context(closing(EmergencyStopKey())) if can_listen() else None
        if bar:
            in_terminal.append(bar)
        if sys.stderr and sys.stderr.isatty():
            from robotcore.view.progress import Progress

            in_terminal.append(stack.enter_context(closing(Progress(hint=bar.hint if bar else str))))
        interrupts.set_suspension_hooks(
            lambda: [each.pause() for each in in_terminal], lambda: [each.go_on() for each in in_terminal]
        )
        observers: list[Observer] = [each for each in (notifier, recorder, drawer, *in_terminal) if each]
        taps = [recorder.layer] if recorder else []
        return run(RunRequest(**_requested(**asked)), observers, taps, on_forced_exit=on_forced_exit)


def _last_words(recorder: Recorder | None, notifier: Notifier | None, *, as_json: bool) -> Callable[[RunResult], None]:
    """Return what tells the end of a process that ends itself, and ends a service; standard output is what it is now.

    A service has an exit status of its own, see `Notifier.choose_exit_status`.
    """
    stdout = sys.stdout

    def tell_the_last(result: RunResult) -> None:
        result, recorded = finish_recording(result, recorder) if recorder else (result, "")
        result = notifier.choose_exit_status(result) if notifier else result
        with redirect_stdout(stdout):
            status = _finish(result, [recorded] if recorded else [], as_json=as_json)
        if notifier:
            os._exit(status)

    return tell_the_last


def _requested(host: str | None, port: str | None, **asked: Any) -> dict[str, Any]:
    """Return the fields of a request: ``--host`` and ``--port`` are options of the backend too."""
    short = {"host": host, "port": port}
    options = {**dict(asked["options"]), **{key: value for key, value in short.items() if value is not None}}
    return {**asked, "options": options, "settings": dict(asked["settings"])}

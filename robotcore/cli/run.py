"""``robotcore run`` runs one app on one backend; ``robotcore demo`` runs the main example in the best simulator."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from robotcore.cli.command_classes import RunCommand, prepare_result, write_result
from robotcore.cli.options import host_option, merge_options, parse_duration, parse_size, port_option, run_options
from robotcore.cli.output import redirect_prints, write, write_failure, write_line, write_lines
from robotcore.cli.output_files import build_recorder, finish_recording
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.deploy.systemd_notify import Notifier
    from robotcore.hal.backend import Backend
    from robotcore.live.live_view import LiveView
    from robotcore.recording.foxglove_server import FoxgloveServer
    from robotcore.recording.recorder import Recorder
    from robotcore.runtime.profiler import Profiler
    from robotcore.runtime.result import RunResult
    from robotcore.runtime.session import Observer
    from robotcore.runtime.signals import SignalGuard
    from robotcore.view.picture import PictureRecorder
    from robotcore.view.progress import ProgressLine


_FIRST_SIMULATOR = "pybullet"
"""The simulator that the demo tries first. Its camera needs no OpenGL, so it works on every machine."""


@click.command("run", cls=RunCommand)
@click.argument("app")
@click.option(
    "--backend", default="kinematic", show_default=True, help="The simulator or robot. List: `robotcore backends`."
)
@click.option(
    "--world", help="A world's name, or its .toml file. Default in simulators: arena. List: `robotcore worlds`."
)
@click.option("--seed", type=int, help="The seed of the world's random variations.")
@run_options
@host_option
@port_option
@click.option(
    "--picture", metavar="FILE", type=click.Path(path_type=Path), help="Draw the run, seen from above, as a PNG."
)
@click.option(
    "--record",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Record the run as an .mcap file, for `robotcore replay` and for Foxglove.",
)
@click.option("--force", "is_forced", is_flag=True, help="Overwrite an existing recording.")
@click.option(
    "--record-jpeg", is_flag=True, help="Record the camera as JPEG. The file is smaller, and cannot be replayed."
)
@click.option(
    "--record-limit",
    metavar="SIZE",
    type=parse_size,
    help="End the recording when its file has this size, such as 500MB. The run goes on.",
)
@click.option(
    "--record-last",
    metavar="DURATION",
    type=parse_duration,
    help="Keep only the end of the recording, such as 10min. --record-limit then shortens it.",
)
@click.option(
    "--view",
    metavar="[HOST:PORT]",
    is_flag=False,
    flag_value="",
    help="Show the run on a web page, in real time, and drive from there. Default: a free port of 127.0.0.1, which "
    "only this machine can reach. 0.0.0.0:8080 is for other machines too.",
)
@click.option(
    "--foxglove",
    metavar="[PORT]",
    type=click.IntRange(0, 2**16 - 1),
    is_flag=False,
    flag_value=8765,
    help="Show the run in Foxglove, in real time. Foxglove connects to this port of 127.0.0.1. Default: 8765.",
)
@click.option("--gui", is_flag=True, help="Open the simulator's window, and run in real time.")
@click.option("--realtime", is_flag=True, help="Slow simulated time down to real time.")
@click.option(
    "--profile", "is_profiled", is_flag=True, help="Show the slowest phases, devices and lines of the app at the end."
)
@click.option("--no-estop-key", is_flag=True, help="Leave the terminal to the app. The space bar is then no e-stop.")
@click.option(
    "--rt",
    "has_real_time_priority",
    is_flag=True,
    help="Give the ticks the real-time priority of Linux, and lock the memory, on a real robot.",
)
@click.option("--keys", is_flag=True, help="Drive by the keys of the terminal in place of the app, in real time.")
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON at the end, and nothing else.")
def command(
    picture: Path | None,
    record: Path | None,
    *,
    is_forced: bool,
    is_profiled: bool,
    no_estop_key: bool,
    keys: bool,
    record_jpeg: bool,
    record_last: float | None,
    record_limit: int | None,
    view: str | None,
    foxglove: int | None,
    as_json: bool,
    **values: Any,
) -> int:
    """Run APP on a backend, and print its result. In a terminal, the space bar is the e-stop.

    APP is a name of `robotcore apps`, or a .py file. The e-stop stops every motor and ends the run.

    Exit status: 0 success, 1 failure, timeout or a success that the simulator does not confirm, 2 wrong usage, 3 a
    device or backend failed, 4 the safety stage stopped the run, 5 the app raised an exception, 128 + n interrupted by
    signal n.
    """
    from robotcore.deploy.systemd_notify import Notifier
    from robotcore.runtime.signals import SignalGuard

    with SignalGuard() as interrupts:
        drawer = _build_picture_recorder(picture)
        recorder = build_recorder(
            record,
            dict(values["options"]),
            is_forced=is_forced,
            is_jpeg=record_jpeg,
            limit=record_limit,
            last_s=record_last,
        )
        profiler = _build_profiler() if is_profiled else None
        notifier = Notifier.from_environment(os.environ)
        prepare_result(as_json=as_json)
        if keys:
            _require_keys(has_estop_key=not no_estop_key)
        written = [] if as_json else _suggest_project_robot(values["robot"])
        with redirect_prints(as_json=as_json) as redirection:
            on_forced_exit = _build_forced_exit_handler(recorder, notifier, redirection, as_json=as_json)
            has_person = keys or view is not None
            is_realtime = values["realtime"] or has_person or foxglove is not None
            values |= {"has_operator": has_person, "realtime": is_realtime}
            result = _run(
                values,
                drawer,
                recorder,
                profiler,
                notifier,
                view,
                foxglove,
                interrupts,
                on_forced_exit,
                has_estop_key=not no_estop_key,
                has_driving_keys=keys,
            )
        interrupts.mask()
        if picture and drawer:
            result, is_saved = _save_picture(result, drawer, picture)
            written += [f"The picture: {picture}"] if is_saved else []
        if recorder:
            result, recorded = finish_recording(result, recorder)
            written += [recorded] if recorded else []
        result = notifier.choose_exit_status(result) if notifier else result
        interrupts.mask(but_last=True)
        return _finish(result, written, profiler, as_json=as_json)


def _require_keys(*, has_estop_key: bool) -> None:
    """Write the help for the keys that drive. Raises UsageError if the terminal cannot read them."""
    from robotcore.cli.driving_keys import HELP
    from robotcore.cli.estop_key import can_listen

    if not has_estop_key:
        text = "--keys needs the space bar as the e-stop. Leave --no-estop-key out"
        raise UsageError(text, kind="keys-without-estop")
    if not can_listen():
        text = "--keys needs a terminal in the foreground. Run the command there, or drive from a web page with --view"
        raise UsageError(text, kind="keys-without-terminal")
    write_line(HELP, is_error=True)


def _suggest_project_robot(robot: str) -> list[str]:
    """Return a line if --robot is not given, and the pyproject.toml in this folder names another robot."""
    get_source = click.get_current_context().get_parameter_source
    if get_source("robot") is not ParameterSource.DEFAULT or not Path("pyproject.toml").is_file():
        return []
    from robotcore.deploy.project import FILE, read_tables

    with suppress(UsageError):  # a run needs no valid pyproject.toml
        table = read_tables(Path()).robotcore
        if table and table.robot and table.robot != robot:
            is_world_given = get_source("world") is not ParameterSource.DEFAULT
            names = {"--robot": table.robot, "--world": None if is_world_given else table.world}
            options = shlex.join(word for name, value in names.items() if value for word in (name, value))
            return [f"The robot was {robot}. To run the robot of {FILE}, add: {options}"]
    return []


def _finish(result: RunResult, written: list[str], profiler: Profiler | None = None, *, as_json: bool) -> int:
    """Write the result, the profile and the lines about written files. Return the exit status.

    It returns also if stdout is closed.
    """
    try:
        write_result(result, as_json=as_json)
        if profiler and result.ticks:
            from robotcore.view.profile_tables import format_profile

            write(format_profile(result, profiler), is_error=as_json)
        for line in written:
            write_line(line, is_error=as_json)
    except BrokenPipeError:
        return result.exit_status or 1
    except OSError as error:
        write_failure(f"the output cannot be written: {error.strerror}")
        return result.exit_status or 1
    return result.exit_status


def _save_picture(result: RunResult, drawer: PictureRecorder, picture: Path) -> tuple[RunResult, bool]:
    """Save the picture if the run began. Return the result, and whether the picture was saved.

    If the picture cannot be written, the returned result has an exit status of at least 1.
    """
    try:
        return result, drawer.save(picture)
    except UsageError as error:
        write_failure(str(error))
        return replace(result, exit_status=result.exit_status or 1, reason=result.reason or str(error)), False


def _build_picture_recorder(picture: Path | None) -> PictureRecorder | None:
    if picture is None:
        return None
    from robotcore.view.page import require_writable
    from robotcore.view.picture import PictureRecorder

    require_writable(picture)
    return PictureRecorder()


def _build_profiler() -> Profiler:
    from robotcore.runtime.profiler import Profiler

    return Profiler()


def _run(
    values: dict[str, Any],
    drawer: PictureRecorder | None,
    recorder: Recorder | None,
    profiler: Profiler | None,
    notifier: Notifier | None,
    view: str | None,
    foxglove: int | None,
    interrupts: SignalGuard,
    on_forced_exit: Callable[[RunResult], None],
    *,
    has_estop_key: bool,
    has_driving_keys: bool,
) -> RunResult:
    from robotcore.cli.estop_key import NO_ESTOP_KEY_NOTE, EmergencyStopKey, can_listen, is_estop_key_missing
    from robotcore.runtime.session import RunRequest, run

    with ExitStack() as stack:
        page = stack.enter_context(closing(_open_page(view))) if view is not None else None
        server = stack.enter_context(closing(_open_foxglove(foxglove))) if foxglove is not None else None
        in_terminal: list[EmergencyStopKey | ProgressLine] = []
        estop_key = EmergencyStopKey(has_driving_keys=has_driving_keys) if has_estop_key and can_listen() else None
        if estop_key:
            stack.enter_context(closing(estop_key))
            in_terminal.append(estop_key)
        if sys.stderr and sys.stderr.isatty():
            from robotcore.view.progress import ProgressLine

            in_terminal.append(
                stack.enter_context(closing(ProgressLine(hint=estop_key.get_hint if estop_key else str)))
            )
        interrupts.before_suspension = lambda: [each.pause() for each in in_terminal]
        interrupts.after_suspension = lambda: [each.resume() for each in in_terminal]
        listening = (notifier, recorder, drawer, profiler, *in_terminal, page, server)
        observers: list[Observer] = [each for each in listening if each]
        taps = [each.layer for each in (recorder, profiler, server) if each]
        result = run(RunRequest(**_build_request_fields(**values)), observers, taps, on_forced_exit=on_forced_exit)
        if has_estop_key and is_estop_key_missing():
            result = replace(result, notes=[*result.notes, NO_ESTOP_KEY_NOTE])
        if server and server.failure:
            write_failure(f"Foxglove got only a part of the run: {server.failure}. Report it as a bug")
        return result


def _open_page(address: str) -> LiveView:
    """Return the observer that shows the run on a web page, and write the page's link.

    address: ``HOST:PORT``; empty for a free port of this machine.
    """
    from robotcore.live.address import Address
    from robotcore.live.live_view import LiveView

    page = LiveView(Address.parse(address) if address else Address())
    write_lines(page.describe_link(), is_error=True)
    return page


def _open_foxglove(port: int) -> FoxgloveServer:
    """Return the observer that shows the run in Foxglove, and write its address."""
    from robotcore.recording.foxglove_server import FoxgloveServer

    server = FoxgloveServer(port)
    write_lines(server.describe_link(), is_error=True)
    return server


def _build_forced_exit_handler(
    recorder: Recorder | None, notifier: Notifier | None, redirection: ExitStack, *, as_json: bool
) -> Callable[[RunResult], None]:
    """Return a function that writes the result of a run whose app hangs, before the process is ended by force.

    The function first closes ``redirection``, which redirects stdout during the run. Under systemd, it also ends the
    process, because `Notifier` may choose another exit status.
    """

    def report_forced_exit(result: RunResult) -> None:
        result, recorded = finish_recording(result, recorder) if recorder else (result, "")
        result = notifier.choose_exit_status(result) if notifier else result
        redirection.close()
        status = _finish(result, [recorded] if recorded else [], as_json=as_json)
        if notifier:
            os._exit(status)

    return report_forced_exit


def _build_request_fields(host: str | None, port: str | None, **values: Any) -> dict[str, Any]:
    options = merge_options(values["options"], host=host, port=port)
    return {**values, "options": options, "settings": dict(values["settings"])}


@click.command("demo")
@click.option("--seed", type=int, default=7, show_default=True, help="The seed of the world's random variations.")
@click.option("--gui", is_flag=True, help="Open the simulator's window.")
@click.option(
    "--picture", type=click.Path(path_type=Path), default=Path("demo.png"), show_default=True, help="The file to draw."
)
def demo(seed: int, picture: Path, *, gui: bool) -> int:
    """Watch the rover find the green ball.

    Chooses the best simulator that works on this machine, prints the reason, and draws a picture of the run.
    """
    from robotcore.cli.main import execute

    backend, why = choose_simulator()
    arguments = ["run", "green-search", "--backend", backend, "--seed", str(seed), "--picture", str(picture)]
    arguments += ["--gui"] if gui else []
    write_line(why)
    write_line(f"$ robotcore {' '.join(arguments)}")
    return execute(arguments)


def choose_simulator() -> tuple[str, str]:
    """Return the name of the simulator for the demo, and the reason for the choice as text.

    The choice is the first physics simulator that works on this machine, else the built-in kinematic simulator.
    """
    from robotcore.hal.backend import loadable_backends

    physical = [backend for backend in loadable_backends() if backend.brings_physics]
    failures: list[str] = []
    for backend in sorted(physical, key=lambda backend: backend.name != _FIRST_SIMULATOR):
        if not (failure := _find_failure(backend)):
            return backend.name, " ".join((*failures, f"{backend.name} ({backend.summary}): the demo runs on it."))
        failures.append(failure)
    return "kinematic", " ".join((*failures, "The demo runs on the built-in kinematic simulator."))


def _find_failure(backend: Backend) -> str:
    """Return why a simulator does not work, with the remedy; an empty text if its smoke test succeeds."""
    if not backend.is_installed:
        return f"{backend.name} is not installed. {backend.remedy}."
    from robotcore.cli.doctor.smoke_test import diagnose
    from robotcore.hal.check_finding import Level

    errors = (finding for finding in diagnose(backend) if finding.level is Level.ERROR)
    return next((f"{backend.name}: {finding.message}." for finding in errors), "")

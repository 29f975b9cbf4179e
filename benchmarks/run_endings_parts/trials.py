"""The trials: runs in their own processes, each ended or failing at a random moment."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from random import Random
from subprocess import DEVNULL, PIPE, Popen, TimeoutExpired
from time import monotonic, sleep
from typing import NamedTuple

MOTORS = ("left_motor", "right_motor")
HANG_S = 20.0
RUN = [sys.executable, "-m", "robotcore", "run"]
APP = str(Path(__file__).with_name("app.py"))
POLL_S = 0.002


LogEntry = tuple[str, float, float]
"""An entry of a log: event, value, and monotonic time in seconds."""


class TrialResult(NamedTuple):
    """The result of a trial: its exit status, whether every motor stopped, and the delay of the last stop in seconds.

    The status is None if the process hung, or if its output should be one line of JSON with this status and is not.
    """

    status: int | None
    is_stopped: bool
    delay_s: float


def run_signalled(directory: Path, random: Random, number: int) -> TrialResult:
    """Execute the app in a run, and send a signal to the process at a random moment."""
    log = directory / "log"
    with run_robotcore(directory, [APP, "--backend", "logging", "--option", f"log={log}"]) as process:
        while not (log.exists() and any(value for _, value, _ in read_log(log))):
            sleep(POLL_S)
        sleep(random.uniform(0.1, 1.0))
        event = monotonic()
        process.send_signal(number)
        return _await_end(process, log, lambda _: event)


def run_failing(directory: Path, random: Random, ending: str) -> TrialResult:
    """Execute the app in a run, and let the app or the camera fail at a random moment."""
    log, after = directory / "log", f"{random.uniform(0.3, 1.2):.3f}"
    options = ["--option", f"log={log}", "--set", f"log={log}"]
    if ending == "loses its camera":
        options += ["--option", f"lost_after_s={after}"]
    else:
        ending = random.choice(["wait", "compute", "catch"]) if ending == "hangs" else ending
        options += ["--set", f"ending={ending}", "--set", f"after_s={after}"]
    with run_robotcore(directory, [APP, "--backend", "logging", *options]) as process:
        return _await_end(process, log)


def run_orphaned(directory: Path, random: Random, number: int) -> tuple[int | None, float, str]:
    """Execute green-search in a simulator that a signal ends.

    Return the exit status of the run, the seconds from the signal to its end, and its output.
    """
    serve = [sys.executable, "-m", "tests.external_simulator.server"]
    with Popen(serve, stdout=PIPE, stderr=DEVNULL, text=True) as server:  # noqa: S603  this project's own
        assert server.stdout
        port = server.stdout.readline().strip()
        arguments = ["green-search", "--backend", "external", "--port", port, "--realtime", "--json"]
        with run_robotcore(directory, arguments) as process:
            sleep(random.uniform(1.5, 3.0))
            event = monotonic()
            server.send_signal(number)
            status = _await_status(process)
            delay = monotonic() - event
            output = process.stdout.read() if process.stdout else ""
        server.kill()
    return status, delay, output


def run_exhausted(directory: Path, random: Random, ending: str, leaks: str) -> TrialResult:
    """Execute an app that uses up threads or memory before it fails. A guardian is present at random."""
    log, after = directory / "log", f"{random.uniform(0.3, 1.2):.3f}"
    ending = random.choice(["wait", "compute", "leak", "catch"]) if ending == "hangs" else ending
    options = ["--option", f"log={log}", "--option", f"is_guarded={random.choice(['true', 'false'])}"]
    settings = [f"log={log}", f"ending={ending}", f"leaks={leaks}", f"after_s={after}"]
    arguments = [APP, "--backend", "logging", "--json", *options]
    arguments += [part for setting in settings for part in ("--set", setting)]
    with run_robotcore(directory, arguments) as process:
        ended = _await_end(process, log, _find_last_command if ending == "continue" else _find_event)
        output = process.stdout.read() if process.stdout else ""
    is_answered = output.count("\n") == 1 and json.loads(output)["exit_status"] == ended.status
    return ended if is_answered else ended._replace(status=None)


@contextmanager
def run_robotcore(directory: Path, arguments: Sequence[str]) -> Iterator[Popen[str]]:
    """Start ``robotcore run`` in another process, with the backends that `register` registered in the directory."""
    path = os.pathsep.join([str(directory), str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
    command = [*RUN, *arguments]
    with Popen(  # noqa: S603  this project's own command
        command, stdin=DEVNULL, stdout=PIPE, stderr=DEVNULL, text=True, env={**os.environ, "PYTHONPATH": path}
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def register(directory: Path) -> None:
    """Register the benchmark's backends for processes that have the directory in ``PYTHONPATH``."""
    package = directory / "run_endings-0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: run-endings\nVersion: 0\n")
    (package / "entry_points.txt").write_text(
        "[robotcore.backends]\n"
        "logging = benchmarks.run_endings_parts.logging_robot:LoggingBackend\n"
        "external = tests.external_simulator.backend:ExternalSimulatorBackend\n"
    )


def read_log(log: Path) -> list[LogEntry]:
    """Return the entries of a log: event, value, time."""
    lines = (line.split() for line in log.read_text().splitlines())
    return [(event, float(value), float(time)) for event, value, time in lines]


def _await_status(process: Popen[str]) -> int | None:
    try:
        return process.wait(HANG_S)
    except TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        return None


def _find_event(entries: Sequence[LogEntry]) -> float:
    return next(time for what, _, time in entries if what == "event")


def _find_last_command(entries: Sequence[LogEntry]) -> float:
    return max(time for what, value, time in entries if what in MOTORS and value)


def _await_end(
    process: Popen[str], log: Path, since_of: Callable[[Sequence[LogEntry]], float] = _find_event
) -> TrialResult:
    """Wait for the end of a process, and read from its log when the motors were stopped.

    since_of: returns the time, for the entries of the log, from which the delay of the stops is measured.
    """
    status = _await_status(process)
    entries = read_log(log)
    since = since_of(entries)
    stops = [_find_stop([(value, time) for what, value, time in entries if what == name]) for name in MOTORS]
    times = [stop for stop in stops if stop is not None]
    return TrialResult(status, len(times) == len(MOTORS), max((max(0.0, stop - since) for stop in times), default=0.0))


def _find_stop(commands: Sequence[tuple[float, float]]) -> float | None:
    """Return the time of a motor's first stop after its last drive command; None if it was not stopped."""
    if not commands or commands[-1][0] != 0:
        return None
    last_drive = max((index for index, (value, _) in enumerate(commands) if value), default=-1)
    return commands[last_drive + 1][1]

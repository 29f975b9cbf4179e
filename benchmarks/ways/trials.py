"""One trial: a run in a process of its own, which ends badly at a random moment while it drives."""

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


Note = tuple[str, float, float]
"""Event, value, time."""


class Ended(NamedTuple):
    """A trial: its exit status, whether every motor had its stop, and the delay of the last stop in seconds.

    The status is None if the process hung, or if its answer is not one line of JSON with that status.
    """

    status: int | None
    is_stopped: bool
    delay_s: float


def signalled(directory: Path, random: Random, number: int) -> Ended:
    """Drive, and be sent a signal."""
    log = directory / "log"
    with running(directory, [APP, "--backend", "witness", "--option", f"log={log}"]) as process:
        while not (log.exists() and any(value for _, value, _ in notes(log))):
            sleep(POLL_S)
        sleep(random.uniform(0.1, 1.0))
        event = monotonic()
        process.send_signal(number)
        return _ended(process, log, lambda _: event)


def going_wrong(directory: Path, random: Random, way: str) -> Ended:
    """Drive, and go wrong from within."""
    log, after = directory / "log", f"{random.uniform(0.3, 1.2):.3f}"
    options = ["--option", f"log={log}", "--set", f"log={log}"]
    if way == "loses its camera":
        options += ["--option", f"lost_after_s={after}"]
    else:
        way = random.choice(["waits", "burns", "is deaf"]) if way == "hangs" else way
        options += ["--set", f"way={way}", "--set", f"after_s={after}"]
    with running(directory, [APP, "--backend", "witness", *options]) as process:
        return _ended(process, log)


def orphaned(directory: Path, random: Random, number: int) -> tuple[int | None, float, str]:
    """Drive in a simulator that dies; return the exit status, how long it took to come to that, and what was said."""
    serve = [sys.executable, "-m", "tests.faraway.server"]
    with Popen(serve, stdout=PIPE, stderr=DEVNULL, text=True) as server:  # noqa: S603  this project's own
        assert server.stdout
        port = server.stdout.readline().strip()
        arguments = ["green-search", "--backend", "faraway", "--port", port, "--realtime", "--json"]
        with running(directory, arguments) as process:
            sleep(random.uniform(1.5, 3.0))
            event = monotonic()
            server.send_signal(number)
            status = _status(process)
            delay = monotonic() - event
            said = process.stdout.read() if process.stdout else ""
        server.kill()
    return status, delay, said


def run_exhausted(directory: Path, random: Random, way: str, leaks: str) -> Ended:
    """Drive, use up the process's threads or memory, and go wrong; with a guardian or without, as the seed has it."""
    log, after = directory / "log", f"{random.uniform(0.3, 1.2):.3f}"
    way = random.choice(["waits", "burns", "leaks on", "is deaf"]) if way == "hangs" else way
    options = ["--option", f"log={log}", "--option", f"is_guarded={random.choice(['true', 'false'])}"]
    settings = [f"log={log}", f"way={way}", f"leaks={leaks}", f"after_s={after}"]
    arguments = [APP, "--backend", "witness", "--json", *options]
    arguments += [part for setting in settings for part in ("--set", setting)]
    with running(directory, arguments) as process:
        ended = _ended(process, log, _last_command if way == "goes on" else _event)
        said = process.stdout.read() if process.stdout else ""
    is_answered = said.count("\n") == 1 and json.loads(said)["exit_status"] == ended.status
    return ended if is_answered else ended._replace(status=None)


@contextmanager
def running(directory: Path, arguments: Sequence[str]) -> Iterator[Popen[str]]:
    """Run robotcore in a process of its own, which finds the backends that are registered in the directory."""
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
    """Let processes that have the directory on their path find the two backends, as those of installed packages."""
    package = directory / "ways-0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: ways\nVersion: 0\n")
    (package / "entry_points.txt").write_text(
        "[robotcore.backends]\n"
        "witness = benchmarks.ways.witness:WitnessBackend\n"
        "faraway = tests.faraway.backend:FarawayBackend\n"
    )


def notes(log: Path) -> list[Note]:
    """Return what was noted: event, value, time."""
    lines = (line.split() for line in log.read_text().splitlines())
    return [(event, float(value), float(time)) for event, value, time in lines]


def _status(process: Popen[str]) -> int | None:
    try:
        return process.wait(HANG_S)
    except TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        return None


def _event(noted: Sequence[Note]) -> float:
    """Return when the app went wrong."""
    return next(time for what, _, time in noted if what == "event")


def _last_command(noted: Sequence[Note]) -> float:
    """Return when a wheel was last told to turn."""
    return max(time for what, value, time in noted if what in MOTORS and value)


def _ended(process: Popen[str], log: Path, since_of: Callable[[Sequence[Note]], float] = _event) -> Ended:
    """Wait for the end, and read what the motors were told since."""
    status = _status(process)
    noted = notes(log)
    since = since_of(noted)
    stops = [_stopped_at([(value, time) for what, value, time in noted if what == name]) for name in MOTORS]
    times = [stop for stop in stops if stop is not None]
    return Ended(status, len(times) == len(MOTORS), max((max(0.0, stop - since) for stop in times), default=0.0))


def _stopped_at(commands: Sequence[tuple[float, float]]) -> float | None:
    """Return when a motor was told the first stop after which it was told nothing else; None where it was not."""
    if not commands or commands[-1][0] != 0:
        return None
    last_drive = max((index for index, (value, _) in enumerate(commands) if value), default=-1)
    return commands[last_drive + 1][1]

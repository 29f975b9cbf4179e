"""Check that every ending of a run stops the motors, and measure how soon.

    python -m benchmarks.run_endings --trials 200 --exhausted 100 --simulators 50

Each trial is a process: the command line runs an app on a robot in real time, whose motors note each command with its
time. At a random moment while the robot drives, the process gets a signal, the app raises or hangs, or the camera
fails. A hanging app waits, computes, or catches every exception. The time is from the event to the stop of the last
motor. For a hang, the event is the last return of the app.

Then apps use up the threads or the memory of their process first, with a guardian or without. If such an app continues,
the time is from the last command. Then half of the simulators in processes of their own are killed during a run, and
half are suspended. The exit status is 1 if a motor was not stopped, or a bound is broken.
"""

from __future__ import annotations

import json
import os
import signal
import statistics
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from random import Random
from subprocess import DEVNULL, PIPE, Popen, TimeoutExpired
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import NamedTuple

from benchmarks.report import parse_options, print_table
from tests.robotcore.safety.guardian.recorder import Note, notes

HANG_BOUND_S, NAMED_BOUND_S = 0.150, 2.0
MOTORS = ("left_motor", "right_motor")
LIMIT_S = 20.0
POLL_S = 0.002
APP = str(Path(__file__).with_name("failing_app.py"))
ENTRY_POINTS = """[robotcore.backends]
logging = benchmarks.logging_robot:LoggingBackend
external = tests.external_simulator.backend:ExternalSimulatorBackend
"""


class TrialResult(NamedTuple):
    """The result of a trial: its exit status, whether every motor stopped, and the delay of the last stop in seconds.

    The status is None if the process hung, or if its output should be one line of JSON with this status and is not.
    """

    status: int | None
    is_stopped: bool
    delay_s: float


Trial = Callable[[Path, Random], TrialResult]


def main() -> int:
    """Execute all trials, and print the results."""
    options = parse_options(__doc__, trials=200, exhausted=100, simulators=50, seed=1)
    random = Random(options.seed)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup, no trial could be hung up
    is_good = [
        _print_endings(KINDS, options.trials, random),
        _print_endings(EXHAUSTION_KINDS, options.exhausted, random),
        _print_simulators(options.simulators, random),
    ]
    return int(not all(is_good))


def _print_endings(kinds: Mapping[str, tuple[Trial, int]], trials: int, random: Random) -> bool:
    ended: dict[str, list[TrialResult]] = {kind: [] for kind in list(kinds)[:trials]}
    for index in range(trials):
        kind = list(kinds)[index % len(kinds)]
        with _make_directory() as directory:
            ended[kind].append(kinds[kind][0](directory, random))
    rows, is_good = [], True
    for kind, results in ended.items():
        delays, count = [result.delay_s * 1e3 for result in results], len(results)
        stopped, expected = (sum(r.is_stopped for r in results), sum(r.status == kinds[kind][1] for r in results))
        times = f"{statistics.median(delays):.0f}", f"{max(delays):.0f}"
        rows.append((kind, f"{stopped}/{count}", f"{expected}/{count}", *times))
        is_good &= stopped == expected == count and not (kind.endswith("hangs") and max(delays) > 1e3 * HANG_BOUND_S)
    columns = ("ending", "every motor stopped", "expected exit status", "ms to the last stop: median", "worst")
    print_table(columns, rows)
    print(f"\n{sum(result.is_stopped for each in ended.values() for result in each)} of {trials} runs stopped\n")
    return is_good


def _print_simulators(count: int, random: Random) -> bool:
    rows, is_good = [], True
    failures = (("killed", signal.SIGKILL, count - count // 2), ("suspended", signal.SIGSTOP, count // 2))
    for what, number, trials in failures[:count]:
        ended = [_run_orphaned(random, number) for _ in range(trials)]
        delays = [delay for _, delay, _ in ended]
        named = sum(status == 3 and delay <= NAMED_BOUND_S and _is_named(output) for status, delay, output in ended)
        hung = sum(status is None for status, _, _ in ended)
        rows.append((what, f"{named}/{trials}", str(hung), f"{statistics.median(delays):.2f}", f"{max(delays):.2f}"))
        is_good &= named == trials
    columns = ("simulator", f"named error within {NAMED_BOUND_S:g} s", "hangs", "s to the end: median", "worst")
    print_table(columns, rows)
    return is_good


def _run_signalled(directory: Path, random: Random, number: int) -> TrialResult:
    """Execute the app in a run, and send a signal to the process at a random moment."""
    diary = directory / "diary"
    with _run_robotcore(directory, [APP, "--backend", "logging", "--option", f"diary={diary}"]) as process:
        while not (diary.exists() and any(note.action.startswith("turn") for note in notes(diary))):
            sleep(POLL_S)
        sleep(random.uniform(0.1, 1.0))
        event = monotonic()
        process.send_signal(number)
        return _await_end(process, diary, lambda _: event)


def _run_failing(directory: Path, random: Random, ending: str) -> TrialResult:
    """Execute the app in a run, and let the app or the camera fail at a random moment."""
    diary, after = directory / "diary", f"{random.uniform(0.3, 1.2):.3f}"
    arguments = [APP, "--backend", "logging", "--option", f"diary={diary}", "--set", f"diary={diary}"]
    if ending == "loses its camera":
        arguments += ["--option", f"lost_after_s={after}"]
    else:
        ending = random.choice(["wait", "compute", "catch"]) if ending == "hangs" else ending
        arguments += ["--set", f"ending={ending}", "--set", f"after_s={after}"]
    with _run_robotcore(directory, arguments) as process:
        return _await_end(process, diary, _find_event)


def _run_exhausted(directory: Path, random: Random, ending: str, leaks: str) -> TrialResult:
    """Execute an app that uses up threads or memory before it fails. A guardian is present at random."""
    diary, after = directory / "diary", f"{random.uniform(0.3, 1.2):.3f}"
    ending = random.choice(["wait", "compute", "leak", "catch"]) if ending == "hangs" else ending
    options = ["--option", f"diary={diary}", "--option", f"is_guarded={random.choice(['true', 'false'])}"]
    settings = [f"diary={diary}", f"ending={ending}", f"leaks={leaks}", f"after_s={after}"]
    arguments = [APP, "--backend", "logging", "--json", *options]
    arguments += [part for setting in settings for part in ("--set", setting)]
    with _run_robotcore(directory, arguments) as process:
        ended = _await_end(process, diary, _find_last_command if ending == "continue" else _find_event)
        output = process.stdout.read() if process.stdout else ""
    is_answered = output.count("\n") == 1 and json.loads(output)["exit_status"] == ended.status
    return ended if is_answered else ended._replace(status=None)


def _run_orphaned(random: Random, number: int) -> tuple[int | None, float, str]:
    """Execute green-search in a simulator that a signal ends.

    Return the exit status of the run, the seconds from the signal to its end, and its output.
    """
    serve = [sys.executable, "-m", "tests.external_simulator.server"]
    with _make_directory() as directory, Popen(serve, stdout=PIPE, stderr=DEVNULL, text=True) as server:  # noqa: S603  our own
        assert server.stdout
        port = server.stdout.readline().strip()
        arguments = ["green-search", "--backend", "external", "--port", port, "--realtime", "--json"]
        with _run_robotcore(directory, arguments) as process:
            sleep(random.uniform(1.5, 3.0))
            event = monotonic()
            server.send_signal(number)
            status = _await_status(process)
            delay = monotonic() - event
            output = process.stdout.read() if process.stdout else ""
        server.kill()
    return status, delay, output


KINDS: Mapping[str, tuple[Trial, int]] = {
    "interrupted (SIGINT)": (partial(_run_signalled, number=signal.SIGINT), -signal.SIGINT),
    "terminated (SIGTERM)": (partial(_run_signalled, number=signal.SIGTERM), -signal.SIGTERM),
    "hung up (SIGHUP)": (partial(_run_signalled, number=signal.SIGHUP), -signal.SIGHUP),
    "raises": (partial(_run_failing, ending="raise"), 5),
    "hangs": (partial(_run_failing, ending="hangs"), 4),
    "loses its camera": (partial(_run_failing, ending="loses its camera"), 3),
}
"""The endings, and the exit status of each, as `subprocess` returns it."""

EXHAUSTION_KINDS: Mapping[str, tuple[Trial, int]] = {
    f"uses up its {what}, {then}": (partial(_run_exhausted, ending=ending, leaks=what), status)
    for what in ("threads", "memory")
    for then, ending, status in (("hangs", "hangs", 4), ("raises", "raise", 5))
} | {"uses up its threads, continues": (partial(_run_exhausted, ending="continue", leaks="threads"), 0)}
"""The endings of apps that first use up threads or memory. Such a run also has to print one line of JSON."""


@contextmanager
def _make_directory() -> Iterator[Path]:
    """Make a directory whose name in ``PYTHONPATH`` registers the backends of the benchmark."""
    with TemporaryDirectory() as folder:
        package = Path(folder, "run_endings-0.dist-info")
        package.mkdir()
        (package / "METADATA").write_text("Metadata-Version: 2.1\nName: run-endings\nVersion: 0\n")
        (package / "entry_points.txt").write_text(ENTRY_POINTS)
        yield Path(folder)


@contextmanager
def _run_robotcore(directory: Path, arguments: Sequence[str]) -> Iterator[Popen[str]]:
    """Start ``robotcore run`` in another process, with the backends that the directory registers."""
    path = os.pathsep.join([str(directory), str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    command, environment = [sys.executable, "-m", "robotcore", "run", *arguments], {**os.environ, "PYTHONPATH": path}
    with Popen(command, stdin=DEVNULL, stdout=PIPE, stderr=DEVNULL, text=True, env=environment) as process:  # noqa: S603  our own
        try:
            yield process
        finally:
            process.kill()


def _await_status(process: Popen[str]) -> int | None:
    try:
        return process.wait(LIMIT_S)
    except TimeoutExpired:
        process.kill()
        return None


def _await_end(process: Popen[str], diary: Path, find_start: Callable[[Sequence[Note]], float]) -> TrialResult:
    """Wait for the end of a process, and read from its diary when the motors were stopped.

    find_start: returns the time, for the entries of the diary, from which the delay of the stops is measured.
    """
    status = _await_status(process)
    entries = notes(diary)
    since = find_start(entries)
    stops = [_find_stop([note for note in entries if note.action.endswith(f" {name}")]) for name in MOTORS]
    times = [stop for stop in stops if stop is not None]
    return TrialResult(status, len(times) == len(MOTORS), max((max(0.0, stop - since) for stop in times), default=0.0))


def _find_event(entries: Sequence[Note]) -> float:
    return next(note.time for note in entries if note.action == "event")


def _find_last_command(entries: Sequence[Note]) -> float:
    return max(note.time for note in entries if note.action.startswith("turn"))


def _find_stop(entries: Sequence[Note]) -> float | None:
    """Return the time of a motor's first stop after its last drive command; None if it was not stopped."""
    last = max((index for index, note in enumerate(entries) if note.action.startswith("turn")), default=-1)
    return next((note.time for note in entries[last + 1 :] if note.action.startswith(("stand", "stop"))), None)


def _is_named(output: str) -> bool:
    reason = json.loads(output).get("reason", "") if output else ""
    return any(name in reason for name in ("_motor", "_encoder", "nose", "eye", "backend"))


if __name__ == "__main__":
    sys.exit(main())

"""Check that the motors stop on each way out of a session of `robotcore.open`, and measure how soon.

    python -m benchmarks.interruptions

Each trial is a program that drives a robot in real time at 20 Hz with a call of a session. At a random moment, the
program gets a signal, its code raises or hangs, or it ends without a close. The motors are doubles that note each
command with the machine's monotonic time, or they are on a PCA9685 on a simulated I2C bus. Both robots have a guardian.
A trial counts if every motor stood within the lease after the event. The lease is that of the guardian if the program
cannot act, and else that of the deadman. A busy machine may wake a process late, so 50 ms more are allowed. The exit
status is 1 if a trial does not count, or if a program has another exit status than expected.
"""

from __future__ import annotations

import os
import signal
import statistics
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import NamedTuple

from benchmarks.interrupted_session import EXIT_STATUS
from benchmarks.report import parse_options, print_table
from robotcore.description import load_robot
from robotcore.runtime.plan import RunRequest
from robotcore.safety.deadman import LOCK_TIMEOUT_S, MIN_LEASE_S
from tests.drivers.raspberrypi.i2c_dev import Bus
from tests.drivers.raspberrypi.lines import Lines
from tests.robotcore.safety.guardian.doubles import MOTORS
from tests.robotcore.safety.guardian.recorder import Note, notes

DELAY_S = 0.05
"""The time in seconds that a busy machine may take to wake a process."""
MOMENTS_S = (0.1, 0.9)
"""The shortest and the longest time between the first command and the event, in seconds."""
LIMIT_S = 30.0
POLL_S = 0.002


class Way(NamedTuple):
    """A way out of a session."""

    text: str
    method: str
    """The method of the session."""
    status: int
    """The exit status, as `subprocess` returns it."""
    number: int | None = None
    """The signal that the program gets."""
    by_guardian: bool = False
    """Whether only the guardian can act."""


class TrialResult(NamedTuple):
    """The result of a trial: the exit status, and the time in seconds until the last motor stood; None for never."""

    status: int
    delay_s: float | None


WAYS = (
    Way("an exception in a routine", "raise_in_routine", 1),
    Way("an exception in a condition", "raise_in_condition", 1),
    Way("an exception between two calls", "raise_between_calls", 1),
    Way("Ctrl-C (SIGINT)", "drive", -signal.SIGINT, signal.SIGINT),
    Way("SIGTERM", "drive", -signal.SIGTERM, signal.SIGTERM),
    Way("the end of the program without a close", "end_without_close", 0),
    Way("sys.exit in a routine", "exit_in_routine", EXIT_STATUS),
    Way("a routine that hangs", "hang", 1),
    Way("SIGKILL", "drive", -signal.SIGKILL, signal.SIGKILL, by_guardian=True),
    Way("the program is suspended (SIGSTOP)", "drive", -signal.SIGKILL, signal.SIGSTOP, by_guardian=True),
    Way("the interpreter lock is held for 0.6 s", "hold_lock", 0, by_guardian=True),
)


def main() -> int:
    """Execute the trials, and print the results."""
    options = parse_options(__doc__, trials=100, seed=1)
    kinds = [(way, run) for way in WAYS for run in ROBOTS]
    results: dict[tuple[Way, str], list[TrialResult]] = {}
    for index in range(options.trials):
        way, robot = kinds[index % len(kinds)]
        with TemporaryDirectory() as folder:
            result = ROBOTS[robot](way, Path(folder), Random(options.seed + index))
        results.setdefault((way, robot), []).append(result)
    columns = ("way out", "motors", "stopped in time", "bound", "median", "worst", "exit status")
    print_table(columns, [_format_row(way, robot, each) for (way, robot), each in results.items()])
    good = sum(_is_good(way, result) for (way, _), each in results.items() for result in each)
    print(f"\n{good} of {options.trials} trials as expected")
    return int(good < options.trials)


def _run_recorded(way: Way, folder: Path, random: Random) -> TrialResult:
    """Execute a trial with motors that note their commands in a diary."""
    diary = folder / "diary"

    def is_turning() -> bool:
        return diary.exists() and any(note.action.startswith("turn") for note in notes(diary))

    status, event = _run(way, "recording", diary, dict(os.environ), is_turning, random)
    entries = notes(diary)
    return TrialResult(status, _compute_delay(event or _find_event(entries), [_find_stop(entries, m) for m in MOTORS]))


def _run_on_chip(way: Way, folder: Path, random: Random) -> TrialResult:
    """Execute a trial with motors on a chip."""
    bus, diary = Bus(folder / "i2c"), folder / "diary"
    lines = Lines(folder / "lines").environment
    path = os.pathsep.join([bus.environment["PYTHONPATH"], lines["PYTHONPATH"]])
    environment = {**lines, **bus.environment, "PYTHONPATH": path}
    status, event = _run(way, "raspberrypi", diary, environment, lambda: any(bus.duties()), random)
    return TrialResult(status, _compute_delay(event or _find_event(notes(diary)), [bus.find_stop()]))


ROBOTS: dict[str, Callable[[Way, Path, Random], TrialResult]] = {"doubles": _run_recorded, "PCA9685": _run_on_chip}


def _run(
    way: Way, backend: str, diary: Path, environment: dict[str, str], is_turning: Callable[[], bool], random: Random
) -> tuple[int, float | None]:
    """Execute a session. Return its exit status, and the time of the signal if it got one."""
    module, after_s = "benchmarks.interrupted_session", random.uniform(*MOMENTS_S)
    command = [sys.executable, "-m", module, backend, way.method, f"{after_s:.3f}", str(diary)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=environment, stdout=pipe, stderr=pipe) as process:  # noqa: S603  our own
        event = None
        if way.number is not None:
            while not is_turning():
                assert process.poll() is None, process.communicate()
                sleep(POLL_S)
            sleep(after_s)
            event = monotonic()
            process.send_signal(way.number)
            if way.number == signal.SIGSTOP:
                sleep(_compute_bound_s(way) + DELAY_S)
                process.kill()
        try:
            process.communicate(timeout=LIMIT_S)  # waits for the guardian too, which inherited standard error
        except subprocess.TimeoutExpired:
            process.kill()
    return process.returncode, event


def _find_event(entries: Sequence[Note]) -> float:
    return next(note.time for note in entries if note.action == "event")


def _find_stop(entries: Sequence[Note], motor: str) -> float | None:
    """Return the time of a motor's first stop after its last velocity. None if it was not stopped."""
    own = [note for note in entries if note.action.endswith(f" {motor}")]
    last = max((at for at, note in enumerate(own) if note.action.startswith("turn")), default=-1)
    return next((note.time for note in own[last + 1 :] if note.action.startswith(("stand", "stop"))), None)


def _compute_delay(event: float, stops: Sequence[float | None]) -> float | None:
    times = [stop for stop in stops if stop is not None]
    return max(0.0, max(times) - event) if len(times) == len(stops) else None


def _compute_bound_s(way: Way) -> float:
    lease_s = max(load_robot("rover").safety.lease_ticks / RunRequest("app").rate_hz, MIN_LEASE_S)
    return lease_s + LOCK_TIMEOUT_S * way.by_guardian + DELAY_S


def _is_in_time(way: Way, result: TrialResult) -> bool:
    return result.delay_s is not None and result.delay_s <= _compute_bound_s(way)


def _is_good(way: Way, result: TrialResult) -> bool:
    return _is_in_time(way, result) and result.status == way.status


def _format_row(way: Way, robot: str, results: Sequence[TrialResult]) -> tuple[str, ...]:
    delays, count = [1e3 * each.delay_s for each in results if each.delay_s is not None], len(results)
    in_time = sum(_is_in_time(way, each) for each in results)
    expected = sum(each.status == way.status for each in results)
    times = (f"{statistics.median(delays):.0f} ms", f"{max(delays):.0f} ms") if delays else ("never", "never")
    bound = f"{1e3 * _compute_bound_s(way):.0f} ms"
    return way.text, robot, f"{in_time}/{count}", bound, *times, f"{expected}/{count}"


if __name__ == "__main__":
    sys.exit(main())

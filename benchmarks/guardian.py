"""Whether the guardian stops the motors where the app's process cannot, and how soon.

    python -m benchmarks.guardian

A robot whose motors and cutoffs note what they are told, and when, by the machine's one monotonic clock, drives at
20 Hz. Its process is killed (SIGKILL) at a random moment, once a trial; or one of its threads holds the interpreter
lock for 0.5 s at random moments, as a vendor's call may. A trial counts where every motor was stopped, during the hold
in the second case; its time is that of the last motor. Exit status 1 where one was not.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import monotonic, sleep

from benchmarks.report import at_least_one, machine, print_table
from robotcore.description import load_robot
from robotcore.runtime.plan import RunRequest
from robotcore.safety.deadman import LOCK_TIMEOUT_S, MIN_LEASE_S
from tests.robotcore.safety.guardian.doubles import MOTORS
from tests.robotcore.safety.guardian.recorder import Note, notes

MOMENTS_S = 0.3
"""A process is killed within this time, some ticks, after its third tick."""


def main() -> int:
    """Make the trials and print what came of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=at_least_one, default=50)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    with TemporaryDirectory() as folder:
        killed = [_killed(Path(folder) / str(seed), Random(asked.seed + seed)) for seed in range(asked.trials)]
        held = list(_held(Path(folder) / "held", asked.trials, asked.seed))
    commanded = f"the last command; the lease is {_lease_ms():.0f} ms"
    print(machine())
    print_table(
        (f"{asked.trials} trials each", "stopped", "median", "worst", "counted from"),
        [
            ("the process is killed (SIGKILL)", *_format_cells(killed), "the kill"),
            ("the interpreter lock is held for 0.5 s", *_format_cells(held), commanded),
        ],
    )
    return int(None in killed + held or len(held) < asked.trials)


def _killed(diary: Path, random: Random) -> float | None:
    """Return how long after the kill the last motor was stopped; None where one was not."""
    process = subprocess.Popen(  # noqa: S603
        [sys.executable, "-m", "tests.robotcore.safety.guardian.guarded_run", "drives", str(diary)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout
    process.stdout.readline()
    sleep(random.uniform(0.0, MOMENTS_S))
    at = monotonic()
    process.kill()
    process.communicate()  # until the guardian has gone, which holds its standard error too
    return _stopped_after(at, notes(diary))


def _held(diary: Path, holds: int, seed: int) -> Iterator[float | None]:
    """Yield how long after the last command the last motor was stopped, for each hold; None where one was not."""
    subprocess.run([sys.executable, "-m", "benchmarks.held_run", str(diary), str(holds), str(seed)], check=True)  # noqa: S603
    notes_read = notes(diary)
    begins, ends = ([note.time for note in notes_read if note.what == what] for what in ("hold", "let go"))
    for begin, end in zip(begins, ends, strict=True):
        command = max(note.time for note in notes_read if note.what.startswith("turn") and note.time < begin)
        yield _stopped_after(command, [note for note in notes_read if begin < note.time < end])


def _stopped_after(time: float, notes_read: Sequence[Note]) -> float | None:
    """Return how long after a time the last motor got its first stop."""
    firsts = [[note.time for note in notes_read if note.what == f"stop {motor}"] for motor in MOTORS]
    return max(min(stops) for stops in firsts) - time if all(firsts) else None


def _format_cells(times: Sequence[float | None]) -> tuple[str, str, str]:
    stopped = [1000 * time for time in times if time is not None]
    if not stopped:
        return f"0/{len(times)}", "never", "never"
    return f"{len(stopped)}/{len(times)}", f"{statistics.median(stopped):.1f} ms", f"{max(stopped):.1f} ms"


def _lease_ms() -> float:
    ticks, rate_hz = load_robot("rover").safety.lease_ticks, RunRequest("app").rate_hz
    return 1000 * (max(ticks / rate_hz, MIN_LEASE_S) + LOCK_TIMEOUT_S)


if __name__ == "__main__":
    sys.exit(main())

"""Measure how reliably and how soon the guardian stops the motors if the app's process cannot.

    python -m benchmarks.guardian

The motors and cutoffs of a robot log each command with the machine's monotonic time, while the robot drives at 20 Hz.
In each trial, the process is killed (SIGKILL) at a random moment, or one of its threads holds the interpreter lock for
0.5 s, as a vendor's library may. A trial counts if every motor was stopped, in the second case during the hold. Its
time is that of the last motor. In further trials, the motors are on a PCA9685 on a simulated I2C bus, and the time is
that of the transfer that switches all of its channels off. The exit status is 1 if a motor was not stopped.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import monotonic, sleep

from benchmarks.report import parse_options, print_table
from robotcore.description import load_robot
from robotcore.runtime.plan import RunRequest
from robotcore.safety.deadman import LOCK_TIMEOUT_S, MIN_LEASE_S
from tests.drivers.raspberrypi.i2c_dev import ALL_OFF, Bus
from tests.drivers.raspberrypi.lines import Lines
from tests.drivers.raspberrypi.pwm.runs import start_app, wait_until
from tests.robotcore.safety.guardian.doubles import MOTORS
from tests.robotcore.safety.guardian.recorder import Note, notes

MOMENTS_S = 0.3
"""The longest time between the third tick of a process and its kill, in seconds."""


def main() -> int:
    """Execute the trials, and print the results."""
    options = parse_options(__doc__, trials=50, seed=1)
    with TemporaryDirectory() as folder:
        killed = [_kill_run(Path(folder) / str(seed), Random(options.seed + seed)) for seed in range(options.trials)]
        on_chip = [
            _kill_chip_run(Path(folder) / f"chip {at}", Random(options.seed + at)) for at in range(options.trials)
        ]
        held = list(_hold_lock(Path(folder) / "held", options.trials, options.seed))
    commanded = f"the last command; the lease is {_compute_lease_ms():.0f} ms"
    print_table(
        (f"{options.trials} trials each", "stopped", "median", "worst", "counted from"),
        [
            ("the process is killed (SIGKILL)", *_format_cells(killed), "the kill"),
            ("the same, with the motors on a PCA9685", *_format_cells(on_chip), "the kill"),
            ("the interpreter lock is held for 0.5 s", *_format_cells(held), commanded),
        ],
    )
    return int(None in killed + on_chip + held or len(held) < options.trials)


def _kill_run(diary: Path, random: Random) -> float | None:
    """Kill a run at a random moment. Return the seconds until all motors were stopped; None if one was not."""
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
    process.communicate()  # waits for the guardian too, which inherited standard error
    return _compute_delay(at, notes(diary))


def _kill_chip_run(folder: Path, random: Random) -> float | None:
    """Kill a run with motors on a chip. Return the seconds until all its channels were off; None if one was not."""
    bus = Bus(folder / "i2c")
    process = start_app(bus, Lines(folder / "lines"), "endless_drive")
    wait_until(bus, process, turning=True)
    sleep(random.uniform(0.0, MOMENTS_S))
    at = monotonic()
    process.kill()
    process.communicate()  # waits for the guardian too, which inherited standard error
    stops = [each.time for each in bus.transfers() if each.register == ALL_OFF and each.time > at]
    return None if any(bus.duties()) or not stops else stops[0] - at


def _hold_lock(diary: Path, holds: int, seed: int) -> Iterator[float | None]:
    """Execute a run that holds the interpreter lock ``holds`` times.

    For each hold, yield the seconds from the last command until all motors were stopped; None if one was not.
    """
    module = "tests.robotcore.safety.guardian.lock_holding_run"
    subprocess.run([sys.executable, "-m", module, str(diary), str(holds), str(seed)], check=True)  # noqa: S603  our own
    entries = notes(diary)
    begins, ends = ([note.time for note in entries if note.action == what] for what in ("hold", "let go"))
    for begin, end in zip(begins, ends, strict=True):
        command = max(note.time for note in entries if note.action.startswith("turn") and note.time < begin)
        yield _compute_delay(command, [note for note in entries if begin < note.time < end])


def _compute_delay(time: float, entries: Sequence[Note]) -> float | None:
    """Return the seconds from a time until each motor had its first stop; None if a motor had no stop."""
    firsts = [[note.time for note in entries if note.action == f"stop {motor}"] for motor in MOTORS]
    return max(min(stops) for stops in firsts) - time if all(firsts) else None


def _format_cells(times: Sequence[float | None]) -> tuple[str, str, str]:
    stopped = [1000 * time for time in times if time is not None]
    if not stopped:
        return f"0/{len(times)}", "never", "never"
    return f"{len(stopped)}/{len(times)}", f"{statistics.median(stopped):.1f} ms", f"{max(stopped):.1f} ms"


def _compute_lease_ms() -> float:
    ticks, rate_hz = load_robot("rover").safety.lease_ticks, RunRequest("app").rate_hz
    return 1000 * (max(ticks / rate_hz, MIN_LEASE_S) + LOCK_TIMEOUT_S)


if __name__ == "__main__":
    sys.exit(main())

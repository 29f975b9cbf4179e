"""Measure what hostile recordings cost the commands that read them. Each command has to end with a result or an error.

    python -m benchmarks.hostile_recordings

The files of `tests.robotcore.recording.hostile_files`, and files with random changes, go through `robotcore info`
with all its outputs, `replay`, `replay --set`, `compare` and `fidelity`, each in its own process. Memory is the largest
resident size of a process with its interpreter and libraries, less the size of the file. Time is processor time.

The exit status is 1 if a bound is broken, if a traceback or a control character is printed, or if an app runs that a
recording names.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory, TemporaryFile
from time import monotonic, sleep
from typing import NamedTuple

from benchmarks.report import parse_options, print_table
from tests.robotcore.recording.hostile_files import PROOF, mutate, name_files
from tests.robotcore.recording.mcap_builder import read_raw

MEMORY_BOUND_MB, TIME_BOUND_S = 300.0, 5.0
HANGS_S = 120.0
STATUSES = (0, 1, 2, 3, 4)
"""The exit statuses of a command: a result, a difference, a named error, a damaged sample, an old sample."""

_CONTROL = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]")


class Cost(NamedTuple):
    """The cost of a command on a file, and the problem of its ending, which is empty if there is none."""

    file: str
    command: str
    megabytes: float
    seconds: float
    fault: str


def main() -> int:
    """Measure the catalogue and the random changes, and print the results."""
    options = parse_options(__doc__, files=200, kinds=1000, seed=1)
    catalogue = list(name_files())[: options.kinds]
    with TemporaryDirectory() as folder:
        base = Path(folder, "base.mcap")
        record = ["run", "green-search", "--seed", "7", "--timeout", "1", "--record", str(base), "--json"]
        subprocess.run([sys.executable, "-m", "robotcore", *record], stdout=subprocess.DEVNULL, check=False)  # noqa: S603  our own
        numbers = range(options.files)
        groups = {
            "a whole recording": list(_measure("whole", base, base)),
            f"{len(catalogue)} hostile files": list(_measure_files(catalogue, _make_file, base)),
            f"{options.files} files changed at random": list(
                _measure_files([f"{options.seed}/{number}" for number in numbers], _make_random_file, base)
            ),
        }
    print_table(
        ("read", "commands", "most memory, MB", "of", "most time, s", "of", "broken"),
        [(name, *_build_row(group)) for name, group in groups.items()],
    )
    print(f"\nBounds: {MEMORY_BOUND_MB:g} MB and {TIME_BOUND_S:g} s a command, interpreter included.")
    broken = [cost for group in groups.values() for cost in group if cost.fault]
    for cost in broken:
        print(f"broken: {cost.command} of {cost.file}: {cost.fault}")
    return int(bool(broken))


def _measure_files(names: list[str], make: Callable[[str, Path, Path], object], base: Path) -> Iterator[Cost]:
    for name in names:
        file = base.with_name("hostile.mcap")
        with ProcessPoolExecutor(1, get_context("spawn")) as pool:  # this process's size counts in that of its children
            pool.submit(make, name, base, file).result()
        yield from _measure(name, base, file)
        if base.with_name(PROOF).exists():
            yield Cost(name, "replay", 0.0, 0.0, "its app was run")
        file.rmdir() if file.is_dir() else file.unlink()


def _make_file(name: str, base: Path, file: Path) -> None:
    name_files()[name](base, file)


def _make_random_file(name: str, base: Path, file: Path) -> None:
    file.write_bytes(mutate(read_raw(base), Random(name)))


def _measure(name: str, base: Path, file: Path) -> Iterator[Cost]:
    outputs = ["--csv", ".", "--picture", "a.png", "--video", "a.mp4"]
    yield _run(name, file, "info", str(file), *outputs)
    yield _run(name, file, "replay", str(file))
    yield _run(name, file, "replay", str(file), "--set", "speed_m_s=0.1")
    yield _run(name, file, "compare", str(base), str(file))
    yield _run(name, file, "fidelity", str(file), "--picture", "b.png")


def _run(name: str, file: Path, *command: str) -> Cost:
    """Execute a command on a file in another process, and measure its cost."""
    with TemporaryDirectory() as work, TemporaryFile("w+", errors="replace") as out:
        options = [sys.executable, "-m", "robotcore", *command]
        process = subprocess.Popen(options, cwd=work, stdout=out, stderr=out)  # noqa: S603  robotcore's own command
        due = monotonic() + HANGS_S
        while not (ended := os.wait4(process.pid, os.WNOHANG))[0]:
            if monotonic() > due:
                process.kill()
            sleep(0.01)
        _, status, usage = ended
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        output = out.read()
    size = 0 if file.is_dir() else file.lstat().st_blocks * 512
    megabytes, seconds = (usage.ru_maxrss * 1024 - size) / 1e6, usage.ru_utime + usage.ru_stime
    fault = ""
    if "Traceback" in output or process.returncode not in STATUSES:
        fault = f"status {process.returncode}: {output.strip().splitlines()[-1] if output.strip() else 'no output'}"
    elif _CONTROL.search(output):
        fault = "the output has a control character"
    elif megabytes > MEMORY_BOUND_MB or seconds > TIME_BOUND_S:
        fault = f"{megabytes:.0f} MB, {seconds:.1f} s"
    return Cost(name, " ".join(command[:1] + command[2:3]), megabytes, seconds, fault)


def _build_row(costs: list[Cost]) -> tuple[str, ...]:
    largest, slowest = max(costs, key=lambda each: each.megabytes), max(costs, key=lambda each: each.seconds)
    memory = f"{largest.megabytes:.0f}", f"{largest.command}, {largest.file}"
    time = f"{slowest.seconds:.2f}", f"{slowest.command}, {slowest.file}"
    return str(len(costs)), *memory, *time, str(sum(bool(each.fault) for each in costs))


if __name__ == "__main__":
    sys.exit(main())

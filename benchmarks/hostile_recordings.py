"""Measure what hostile recordings cost the commands that read them. Each command has to end with a result or an error.

    python -m benchmarks.hostile_recordings

The files of `tests.robotcore.recording.hostile_files.files` go through `robotcore info` with all its outputs, `replay`,
`replay --set` and `compare`, each in its own process. Then files with random changes go through `info --csv`, 500 in
a process. Every tenth file goes through `replay` and `info --picture --video` too. Memory is the largest resident size
of a process with its interpreter and libraries, less the size of the file. Time is processor time.

The exit status is 1 if a bound is broken, if a traceback or a control character is printed, or if an app runs that a
recording names.
"""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from random import Random
from time import monotonic, process_time, sleep
from typing import NamedTuple, TypeVar

from benchmarks.report import parse_options, print_table
from robotcore.cli.main import execute
from tests.robotcore.recording.hostile_files.files import PROOF, name_files
from tests.robotcore.recording.hostile_files.mutations import SourceRecording, mutate

MEMORY_BOUND_MB, TIME_BOUND_S = 300.0, 5.0
HANGS_S = 120.0
BATCH = 500
STATUSES = (0, 1, 2, 3, 4)
"""The exit statuses of a command: a result, a difference, a named error, a damaged sample, an old sample."""
_CONTROL = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]")
_COMMAND = "from robotcore.cli.main import main; main()"

ResultT = TypeVar("ResultT")


class Cost(NamedTuple):
    """The cost of a command on a file, and the problem of its ending, which is empty if there is none."""

    file: str
    command: str
    megabytes: float
    seconds: float
    fault: str


def main() -> int:
    """Measure the catalogue and the random changes, and print the results."""
    options = parse_options(__doc__, files=10_000, kinds=1000, seed=1, small=False)
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "base.mcap"
        _record(base)
        costs = [
            *_measure_catalogue(base, options.kinds, is_small=options.small),
            *_measure_fuzzed(base, options.seed, options.files),
        ]
    _print(costs, options.files)
    return int(any(each.fault for each in costs))


def _record(file: Path) -> None:
    options = ["run", "green-search", "--seed", "7", "--timeout", "1", "--record", str(file), "--json"]
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        assert execute(options) == 1


def _measure_catalogue(base: Path, kinds: int, *, is_small: bool) -> Iterator[Cost]:
    work = base.with_name("work")
    work.mkdir()
    yield from _measure("whole", base, base, work)
    for name in islice(name_files(), kinds):
        file = base.with_name(f"{name}.mcap")
        _call_apart(_make_file, name, base, file, is_small)
        yield from _measure(name, base, file, work)
        if base.with_name(PROOF).exists():
            yield Cost(name, "replay", 0.0, 0.0, "its app was run")
        file.rmdir() if file.is_dir() else file.unlink()


def _call_apart(function: Callable[..., ResultT], *arguments: object) -> ResultT:
    """Call a function in a new process, because the size of this process counts in its children's memory."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def _make_file(name: str, base: Path, file: Path, is_small: bool) -> None:  # noqa: FBT001  `submit` passes it
    name_files(is_small=is_small)[name](base, file)


def _measure(name: str, base: Path, file: Path, work: Path) -> Iterator[Cost]:
    outputs = ["--csv", str(work), "--picture", str(work / "a.png"), "--video", str(work / "a.mp4")]
    for command in (
        ["info", str(file), *outputs],
        ["replay", str(file)],
        ["replay", str(file), "--set", "speed_m_s=0.1"],
        ["compare", str(base), str(file)],
    ):
        yield _run_apart(name, command, file, work)


def _run_apart(name: str, command: list[str], file: Path, work: Path) -> Cost:
    """Execute a command on a file in another process, and measure its cost."""
    with tempfile.TemporaryFile("w+", errors="replace") as out:
        options = [sys.executable, "-c", _COMMAND, *command]
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
    return _judge(name, " ".join(command[:1] + command[2:3]), megabytes, seconds, process.returncode, output)


def _judge(name: str, command: str, megabytes: float, seconds: float, status: int, output: str) -> Cost:
    fault = ""
    if "Traceback" in output or status not in STATUSES:
        fault = f"status {status}: {output.strip().splitlines()[-1] if output.strip() else 'no word'}"
    elif _CONTROL.search(output):
        fault = "the output has a control character"
    elif megabytes > MEMORY_BOUND_MB or seconds > TIME_BOUND_S:
        fault = f"{megabytes:.0f} MB, {seconds:.1f} s"
    return Cost(name, command, megabytes, seconds, fault)


def _measure_fuzzed(base: Path, seed: int, count: int) -> Iterator[Cost]:
    for begin in range(0, count, BATCH):
        try:
            yield from _call_apart(_run_batch, base, seed, range(begin, min(begin + BATCH, count)))
        except Exception as error:  # noqa: BLE001, PERF203  each is a finding
            yield Cost(f"random {begin}", "batch", 0.0, 0.0, repr(error))


def _run_batch(base: Path, seed: int, numbers: range) -> list[Cost]:
    """Return the costs of files with random changes. The memory is the peak of the process so far."""
    original, costs = SourceRecording.of(base), []
    signal.signal(signal.SIGALRM, _give_up)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "random.mcap"
        for number in numbers:
            file.write_bytes(mutate(original, Random(f"{seed}/{number}")))
            commands = [["info", str(file), "--csv", folder]]
            if number % 10 == 0:
                drawn = ["--picture", f"{folder}/a.png", "--video", f"{folder}/a.mp4"]
                commands += [["replay", str(file)], ["info", str(file), *drawn]]
            costs += [_run_here(f"random {number}", command, file.stat().st_size) for command in commands]
    return costs


def _run_here(name: str, command: list[str], size: int) -> Cost:
    out, begun = StringIO(), process_time()
    signal.setitimer(signal.ITIMER_REAL, HANGS_S)
    try:
        with redirect_stdout(out), redirect_stderr(out):
            status = execute(command)
    except BaseException:  # noqa: BLE001  each is a finding
        status = 1
        out.write(traceback.format_exc())
    signal.setitimer(signal.ITIMER_REAL, 0)
    seconds = process_time() - begun
    megabytes = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - size) / 1e6
    return _judge(name, " ".join(command[:1] + command[2:3]), megabytes, seconds, status, out.getvalue())


def _give_up(*_: object) -> None:
    raise TimeoutError(f"no end after {HANGS_S:g} s")


def _print(costs: list[Cost], files: int) -> None:
    whole, catalogue, fuzzed = list[Cost](), list[Cost](), list[Cost]()
    for each in costs:
        (whole if each.file == "whole" else fuzzed if each.file.startswith("random ") else catalogue).append(each)
    groups = {
        "a whole recording": whole,
        f"{len({each.file for each in catalogue})} hostile files": catalogue,
        f"{files} files changed at random": fuzzed,
    }
    rows = [(name, *_build_row(group)) for name, group in groups.items() if group]
    print_table(("read", "commands", "most memory, MB", "of", "most time, s", "of", "broken"), rows)
    print(f"\nBounds: {MEMORY_BOUND_MB:g} MB and {TIME_BOUND_S:g} s a command, interpreter included; 0 broken.")
    for each in costs:
        if each.fault:
            print(f"broken: {each.command} of {each.file}: {each.fault}")


def _build_row(costs: list[Cost]) -> tuple[str, ...]:
    largest, slowest = max(costs, key=lambda each: each.megabytes), max(costs, key=lambda each: each.seconds)
    memory = f"{largest.megabytes:.0f}", f"{largest.command}, {largest.file}"
    time = f"{slowest.seconds:.2f}", f"{slowest.command}, {slowest.file}"
    return str(len(costs)), *memory, *time, str(sum(bool(each.fault) for each in costs))


if __name__ == "__main__":
    sys.exit(main())

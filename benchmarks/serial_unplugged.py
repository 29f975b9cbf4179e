"""Check that a board that is unplugged while it drives stops, and drives again when it is plugged in.

    python -m benchmarks.serial_unplugged

`robotcore run` drives a double of each board on a pseudo-terminal, in its own process and in real time. At random
moments the port is removed while the wheels turn. A stop counts if the board's own time-out stops the wheels, because
no command can reach it. After a random time the port comes back. A recovery counts if the same run turns the wheels
again. The times are from the loss to the stop, and from the port's return to the first command that turns a wheel. The
exit status is 1 if one is missing.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks.report import at_least_one, machine, print_table
from benchmarks.unplugged.boards import BOARDS, BoardModel, build_robot_file
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.serial.board import Powered, Wheels
from tests.doubles.serial.pty import Pty

APP = Path(__file__).parent / "unplugged" / "endless_arc.py"
LOOK_S = 0.002
LONGEST_S = 20.0
"""The time limit for an event, in seconds."""


@dataclass
class UnplugResult:
    """The delays of all stops and recoveries of a board in seconds, and the end of its run."""

    stops: list[float] = field(default_factory=list)
    recoveries: list[float] = field(default_factory=list)
    ended: str = ""


def main() -> int:
    """Unplug every board, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=at_least_one, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--board", choices=BOARDS, action="append")
    options = parser.parse_args()
    rows, is_whole = [], True
    for name in options.board or BOARDS:
        result = _unplug_board(BOARDS[name], options.trials, Random(options.seed))
        rows.append(
            (
                name,
                *_format_cells(result.stops, options.trials),
                *_format_cells(result.recoveries, options.trials),
                result.ended,
            )
        )
        is_whole &= len(result.stops) == len(result.recoveries) == options.trials
    print(machine())
    print_table(("board", "stops", "median", "worst", "recoveries", "median", "worst", "the run"), rows)
    return int(not is_whole)


def _unplug_board(kind: BoardModel, trials: int, random: Random) -> UnplugResult:
    clock, result = MonotonicClock(), UnplugResult()
    with TemporaryDirectory() as folder, Pty(Path(folder)) as pty:
        board = kind.make()
        powered = Powered(board, pty, clock)
        robot = Path(folder, "robot.toml")
        robot.write_text(build_robot_file(kind, pty.path), encoding="utf-8")
        run = _start_run(robot)
        try:
            _try_all(pty, kind.wheels_of(board), clock, trials, random, result)
        finally:
            run.send_signal(signal.SIGINT)
            result.ended = _read_end(run)
            powered.off()
    return result


def _try_all(
    pty: Pty, wheels: Wheels, clock: MonotonicClock, trials: int, random: Random, result: UnplugResult
) -> None:
    if _await_condition(lambda: _are_wheels_turning(wheels), clock) is None:
        return
    for _ in range(trials):
        _sleep(clock, random.uniform(0.1, 1.0))
        pty.unplug()
        stopped = _await_condition(lambda: not _are_wheels_turning(wheels), clock)
        _sleep(clock, random.uniform(0.0, 1.5))
        pty.plug_in()
        turned = _await_condition(lambda: _are_wheels_turning(wheels), clock)
        result.stops += [] if stopped is None else [stopped]
        result.recoveries += [] if turned is None else [turned]


def _are_wheels_turning(wheels: Wheels) -> bool:
    return bool(wheels.left.command or wheels.right.command)


def _await_condition(is_met: Callable[[], bool], clock: MonotonicClock) -> float | None:
    began = clock.now()
    while not is_met():
        if clock.now() - began > LONGEST_S:
            return None
        _sleep(clock, LOOK_S)
    return clock.now() - began


def _sleep(clock: MonotonicClock, seconds: float) -> None:
    clock.sleep_until(clock.now() + seconds)


def _start_run(robot: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "robotcore", "run", str(APP), "--backend", "serial", "--robot", str(robot)]
    return subprocess.Popen(  # noqa: S603
        [*command, "--timeout", "86400"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def _read_end(run: subprocess.Popen[str]) -> str:
    output, _ = run.communicate(timeout=LONGEST_S)
    notes = [line.removeprefix("note: ") for line in output.splitlines() if " was lost " in line]
    return f"{run.returncode}: {'; '.join(notes) or output.strip()}"


def _format_cells(seconds: list[float], trials: int) -> tuple[str, str, str]:
    if not seconds:
        return f"0/{trials}", "", ""
    return f"{len(seconds)}/{trials}", f"{median(seconds):.2f} s", f"{max(seconds):.2f} s"


if __name__ == "__main__":
    sys.exit(main())

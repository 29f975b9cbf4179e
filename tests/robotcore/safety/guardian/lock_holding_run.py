"""A program that executes a run while a thread holds the interpreter lock at random moments.

`benchmarks.guardian` starts it.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path
from random import Random
from threading import Thread
from time import sleep

from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from tests.robotcore.fakes import FunctionApp
from tests.robotcore.safety.guardian.doubles import RecordingBackend
from tests.robotcore.safety.guardian.guarded_run import Causes, run_on
from tests.robotcore.safety.guardian.recorder import Diary

HOLD_S = 0.5
BETWEEN_S = (0.3, 0.6)


def main() -> int:
    """Execute the run until the thread has held the lock often enough. Return the exit status of the run."""
    file, holds, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    holder = Thread(target=_hold, args=(Diary(file), holds, Random(seed)))

    def drive(robot: Robot) -> Status:
        if holder.ident is None:
            holder.start()
        robot.drive.set_wheels(2.0, 2.0)
        return Status.RUNNING if holder.is_alive() else Status.SUCCESS

    return run_on(RecordingBackend(file), FunctionApp(drive), Causes(), timeout_s=1e6).exit_status


def _hold(diary: Diary, holds: int, random: Random) -> None:
    for _ in range(holds):
        sleep(random.uniform(*BETWEEN_S))
        diary.note("hold")
        ctypes.PyDLL(None).usleep(int(1e6 * HOLD_S))
        diary.note("let go")


if __name__ == "__main__":
    sys.exit(main())

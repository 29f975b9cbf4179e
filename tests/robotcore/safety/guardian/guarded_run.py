"""A run that a test disturbs: ``python -m tests.robotcore.safety.guardian.guarded_run APP DIARY [MANNER]``."""

from __future__ import annotations

import ctypes
import json
import math
import os
import signal
import sys
import threading
import time
import warnings
from contextlib import suppress
from pathlib import Path
from unittest.mock import patch

from robotcore.hal.backend import Backend
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.session import Observer, RunContext, RunRequest, RunResult, run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.fakes import FunctionApp
from tests.robotcore.safety.guardian.doubles import RecordingBackend, RecordingMotor
from tests.robotcore.safety.guardian.recorder import Diary

HANG_S = 3600.0
HOARD: list[bytearray] = []

HOLD_US = 800_000


class App(FunctionApp):
    """Drives, and from its third tick on also runs the given step."""

    ticks = 0

    def step(self, robot: Robot) -> Status:
        self.ticks += 1
        robot.drive.set_wheels(2.0, 2.0)
        if self.ticks == 3:
            print_line("moving")
        return super().step(robot) if self.ticks >= 3 else Status.RUNNING


class Causes:
    """Collects the causes of the interventions."""

    def __init__(self) -> None:
        self.causes: list[str] = []

    def begin(self, run: RunContext) -> None: ...

    def tick(self, record: TickRecord) -> None:
        self.causes += [each.cause for each in record.interventions]

    def end(self, result: RunResult) -> None: ...


def print_line(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


class Steps:
    """The steps of the apps, each named by its method."""

    def __init__(self, diary: Diary) -> None:
        self._diary = diary
        self._ticks = 0

    def drives(self, robot: Robot) -> Status:
        return Status.RUNNING

    def ends(self, robot: Robot) -> Status:
        self._ticks += 1
        return Status.SUCCESS if self._ticks == 5 else Status.RUNNING

    def rests(self, robot: Robot) -> Status:
        robot.drive.stop()
        return Status.RUNNING

    def grips(self, robot: Robot) -> Status:
        """Stop the drive, and turn a motor outside of it."""
        robot.drive.stop()
        gripper = robot["gripper"]
        assert isinstance(gripper, Motor)
        gripper.set_velocity(1.0)
        return Status.RUNNING

    def sticks(self, robot: Robot) -> Status:
        RecordingMotor.are_stuck = True
        return Status.SUCCESS

    def crashes(self, robot: Robot) -> Status:
        signal.signal(signal.SIGABRT, signal.SIG_DFL)
        os.abort()

    def exits(self, robot: Robot) -> Status:
        os._exit(0)

    def forks(self, robot: Robot) -> Status:
        """Fork a process that lives until stdin is closed."""
        if self._ticks == 0:
            self._copy()
        self._ticks += 1
        return Status.RUNNING

    def forks_and_returns(self, robot: Robot) -> Status:
        """Fork a process that returns from ``step`` too."""
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks of a process that has threads
        if self._ticks == 0:
            self._diary.note("copied" if os.fork() == 0 else "original")
        self._ticks += 1
        return Status.SUCCESS if self._ticks == 5 else Status.RUNNING

    def is_traced_and_hangs(self, robot: Robot) -> Status:
        """Hang for longer than the watchdog's limit under a tracer, and return."""

        def trace(*_: object) -> object:
            return trace

        sys.settrace(trace)  # type: ignore[arg-type]
        threading.Event().wait(4.0)
        sys.settrace(None)
        return Status.SUCCESS

    def holds(self, robot: Robot) -> Status:
        """Hold the interpreter lock twice, as a vendor's call may. Drive between the two holds and after them."""
        self._ticks += 1
        if self._ticks in (1, 10):
            self._diary.note("hold")
            ctypes.PyDLL(None).usleep(HOLD_US)
            self._diary.note("release")
        return Status.SUCCESS if self._ticks == 20 else Status.RUNNING

    def leaks_threads_and_hangs(self, robot: Robot) -> Status:
        use_up_threads()
        time.sleep(HANG_S)
        return Status.RUNNING

    def leaks_threads_and_raises(self, robot: Robot) -> Status:
        use_up_threads()
        raise KeyError("lost")

    def leaks_threads_and_drives_on(self, robot: Robot) -> Status:
        use_up_threads()
        self._ticks += 1
        return Status.SUCCESS if self._ticks == 5 else Status.RUNNING

    def leaks_threads_and_asks_for_nan(self, robot: Robot) -> Status:
        use_up_threads()
        robot.drive.set_wheels(math.nan, 2.0)
        return Status.RUNNING

    def leaks_memory_and_hangs(self, robot: Robot) -> Status:
        use_up_memory()
        time.sleep(HANG_S)
        return Status.RUNNING

    def leaks_memory_and_raises(self, robot: Robot) -> Status:
        use_up_memory()
        raise KeyError("lost")

    def leaks_memory_and_drives_on(self, robot: Robot) -> Status:
        use_up_memory()
        return Status.RUNNING

    def _copy(self) -> None:
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks of a process that has threads
        if os.fork() == 0:
            self._diary.note("copied")
            sys.stdin.read()  # until the test closes it
            os._exit(0)


def limit_address_space(bytes_left: int) -> None:
    """Limit the process to this many bytes more than it uses now."""
    import resource

    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + bytes_left, resource.RLIM_INFINITY))


def use_up_threads() -> None:
    """Start threads until the system has no room for another stack."""
    limit_address_space(64 << 20)
    leak_threads()


def leak_threads() -> None:
    """Start threads until the system refuses one."""
    with suppress(RuntimeError):
        while True:
            threading.Thread(target=threading.Event().wait, daemon=True).start()


def use_up_memory() -> None:
    """Allocate smaller and smaller blocks until none is left."""
    limit_address_space(64 << 20)
    leak_memory()


def leak_memory() -> None:
    """Allocate smaller and smaller blocks until the system refuses one."""
    for size in (1 << 20, 1 << 14, 1 << 8, 1):
        try:  # no `suppress`: making one takes memory
            while True:
                HOARD.append(bytearray(size))
        except MemoryError:  # noqa: PERF203
            continue


def run_on(backend: Backend, app: Behaviour, observer: Observer, timeout_s: float = 60.0) -> RunResult:
    """Run an app on a backend that has no entry point."""
    with (
        patch("robotcore.runtime.plan.load_backend", lambda _: backend),
        patch("robotcore.runtime.plan.load_app", lambda _: object),
        patch("robotcore.runtime.plan.configure", lambda *_: app),
    ):
        return run(RunRequest("app", timeout_s=timeout_s), [observer])


def main() -> int:
    """Run the app that the command line names. Print its result and the causes of interventions as JSON."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # also if the parent process ignores it
    app, file, *manner = sys.argv[1:]
    causes = Causes()
    result = run_on(RecordingBackend(Path(file), *manner), App(getattr(Steps(Diary(file)), app)), causes)
    print_line(json.dumps({**json.loads(result.to_json()), "causes": causes.causes}))
    return result.exit_status


if __name__ == "__main__":
    sys.exit(main())

"""A run of null devices that a test interrupts.

Start it with ``python -m tests.robotcore.runtime.interrupted_run APP [in_a_thread]``.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
import threading
from contextlib import suppress
from unittest.mock import patch

from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.session import RunRequest, RunResult, run
from tests.robotcore.fakes import FunctionApp, RigBackend
from tests.robotcore.runs import Watcher


class App(FunctionApp):
    """Drives, and calls a function from its third tick on."""

    ticks = 0

    def step(self, robot: Robot) -> Status:
        robot.drive.set_wheels(2.0, 2.0)
        self.ticks += 1
        if self.ticks == 3:
            write("moving")
        if self.ticks >= 3:
            super().step(robot)
        return Status.RUNNING


def write(line: str) -> None:
    """Write a line past Python's buffer. A signal handler may run while the buffer is locked."""
    os.write(sys.stdout.fileno(), f"{line}\n".encode())


def ordinary(robot: Robot) -> None:
    """Do nothing."""


def hung(robot: Robot) -> None:
    while True:
        pass


def waiting(robot: Robot) -> None:
    threading.Event().wait()


def deaf(robot: Robot) -> None:
    """Catch every exception, and continue."""
    with suppress(BaseException):
        threading.Event().wait(0.3)


def impervious(robot: Robot) -> None:
    """Catch every exception for ever. Write a line each time before waiting."""
    while True:
        with suppress(BaseException):
            write("impervious")
            threading.Event().wait()


def beyond_python(robot: Robot) -> None:
    """Wait in C code that no signal interrupts, for a lock that this thread holds."""
    threads, mutex = ctypes.CDLL(None), ctypes.create_string_buffer(256)
    threads.pthread_mutex_init(mutex, None)
    threads.pthread_mutex_lock(mutex)
    threads.pthread_mutex_lock(mutex)


class EndObserver(Watcher):
    """Writes a line at the end of the run."""

    def end(self, result: RunResult) -> None:
        write("observed")


STEPS = (ordinary, hung, waiting, deaf, impervious, beyond_python)


def main() -> int:
    """Run the app that the command line names, and print the result."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    step = {each.__name__: each for each in STEPS}[sys.argv[1]]
    backend = RigBackend()

    def write_all(result: RunResult) -> None:
        rig = backend.rig
        rig_state = {"wheels": rig.wheels, "releases": [rig.left.releases, rig.right.releases]}
        write(json.dumps({**json.loads(result.to_json()), **rig_state}))

    results: list[RunResult] = []

    def perform() -> None:
        results.append(run(RunRequest("app", timeout_s=1e9), [EndObserver()], on_forced_exit=write_all))

    with (
        patch("robotcore.runtime.plan.load_backend", lambda _: backend),
        patch("robotcore.runtime.plan.load_app", lambda _: object),
        patch("robotcore.runtime.plan.configure", lambda *_: App(step)),
    ):
        if "in_a_thread" in sys.argv:
            thread = threading.Thread(target=perform)
            thread.start()
            thread.join()
        else:
            perform()
    write_all(results[0])
    return results[0].exit_status


if __name__ == "__main__":
    sys.exit(main())

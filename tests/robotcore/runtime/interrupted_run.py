"""A run of null devices to be interrupted: ``python -m tests.robotcore.runtime.interrupted_run APP``."""

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
from tests.robotcore.fakes import Deed, RigBackend
from tests.robotcore.runs import Watcher


class App(Deed):
    """Drives; from its third tick on it does the deed."""

    ticks = 0

    def step(self, robot: Robot) -> Status:
        robot.drive.set_wheels(2.0, 2.0)
        self.ticks += 1
        if self.ticks == 3:
            tell("moving")
        if self.ticks >= 3:
            super().step(robot)
        return Status.RUNNING


def tell(line: str) -> None:
    """Write a line past Python's buffer: a signal that is heard while that is flushed finds it locked."""
    os.write(sys.stdout.fileno(), f"{line}\n".encode())


def ordinary(robot: Robot) -> None:
    """Go on."""


def slow(robot: Robot) -> None:
    threading.Event().wait(0.3)


def hung(robot: Robot) -> None:
    while True:
        pass


def waiting(robot: Robot) -> None:
    threading.Event().wait()


def swallowing(robot: Robot) -> None:
    while True:
        with suppress(Exception):
            threading.Event().wait()


def deaf(robot: Robot) -> None:
    """Swallow even what ends the program, and go on."""
    with suppress(BaseException):
        threading.Event().wait(0.3)


def impervious(robot: Robot) -> None:
    """Swallow whatever is raised, for ever; say each time when that has begun."""
    while True:
        with suppress(BaseException):
            tell("impervious")
            threading.Event().wait()


def beyond_python(robot: Robot) -> None:
    """Wait in somebody's C code, which no signal interrupts: for a lock that the thread has itself."""
    threads, mutex = ctypes.CDLL(None), ctypes.create_string_buffer(256)
    threads.pthread_mutex_init(mutex, None)
    threads.pthread_mutex_lock(mutex)
    threads.pthread_mutex_lock(mutex)


class Saying(Watcher):
    """Says that it was told the end."""

    def end(self, result: RunResult) -> None:
        tell("observed")


DEEDS = (ordinary, slow, hung, waiting, swallowing, deaf, impervious, beyond_python)


def main() -> int:
    """Run the app that the command line names; print what was left of it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    deed = {each.__name__: each for each in DEEDS}[sys.argv[1]]
    backend = RigBackend()

    def tell_all(result: RunResult) -> None:
        rig = backend.rig
        rig_state = {"wheels": rig.wheels, "releases": [rig.left.releases, rig.right.releases]}
        tell(json.dumps({**json.loads(result.to_json()), **rig_state}))

    with (
        patch("robotcore.runtime.plan.load_backend", lambda _: backend),
        patch("robotcore.runtime.plan.load_app", lambda _: object),
        patch("robotcore.runtime.plan.configure", lambda *_: App(deed)),
    ):
        result = run(RunRequest("app", timeout_s=1e9), [Saying()], on_forced_exit=tell_all)
    tell_all(result)
    return result.exit_status


if __name__ == "__main__":
    sys.exit(main())

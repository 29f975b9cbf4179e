"""An app that drives, and fails after a given time."""

from __future__ import annotations

import resource
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread
from time import sleep
from typing import Literal

from benchmarks.run_endings_parts.logging_robot import Log
from robotcore import Behaviour, Robot, Role, Status

FOREVER_S = 3600.0
LEFT_BYTES = 64 << 20
BLOCKS: list[bytearray] = []


def use_up(what: Literal["nothing", "threads", "memory"]) -> None:
    """Limit the address space of the process, and leak threads or memory until the system refuses more."""
    if what != "nothing":
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + LEFT_BYTES, resource.RLIM_INFINITY))
        leak(what)


def leak(what: Literal["threads", "memory"]) -> None:
    """Start threads, or allocate smaller and smaller blocks of memory, until the system refuses."""
    try:
        while what == "threads":
            Thread(target=Event().wait, daemon=True).start()
    except (RuntimeError, MemoryError):
        return
    for size in (1 << 20, 1 << 14, 1 << 8, 1):
        try:  # no `suppress`: making one takes memory
            while True:
                BLOCKS.append(bytearray(size))
        except MemoryError:  # noqa: PERF203
            continue


@dataclass
class FailingApp(Behaviour):
    """Drives a curve, and fails in the way ``ending``, ``after_s`` seconds after its first tick.

    Before it fails, it writes the time to the file ``log``, and uses up ``leaks``.
    """

    log: str = ""
    ending: Literal["continue", "raise", "wait", "compute", "leak", "catch"] = "continue"
    leaks: Literal["nothing", "threads", "memory"] = "nothing"
    after_s: float = 1.0
    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    _first_s = float("inf")
    _has_failed = False
    _ticks_left = 5

    def step(self, robot: Robot) -> Status:
        robot.camera.read()
        robot.drive.set_velocity(0.1, 0.2)
        now = robot.clock.now()
        self._first_s = min(self._first_s, now)
        if now - self._first_s >= self.after_s:
            if not self._has_failed:
                self._has_failed = True
                Log(self.log).write("event")
                use_up(self.leaks)
            if self.ending != "continue":
                self._fail()
            self._ticks_left -= self.leaks != "nothing"
            if not self._ticks_left:
                return Status.SUCCESS
        return Status.RUNNING

    def _fail(self) -> None:
        if self.ending == "raise":
            raise RuntimeError("failed")
        while self.ending == "compute":
            pass
        while self.ending == "wait":
            sleep(FOREVER_S)
        while self.ending == "leak" and self.leaks != "nothing":
            leak(self.leaks)
        while True:  # "catch"
            with suppress(BaseException):
                sleep(FOREVER_S)

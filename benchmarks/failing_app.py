"""An app of `benchmarks.run_endings` that drives, and fails after a given time."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from threading import Event
from typing import Literal

from robotcore import Behaviour, Robot, Role, Status
from tests.robotcore.safety.guardian.guarded_run import HANG_S, leak_memory, leak_threads, limit_address_space
from tests.robotcore.safety.guardian.recorder import Diary

LEAKS = {"threads": leak_threads, "memory": leak_memory}


@dataclass
class FailingApp(Behaviour):
    """Drives a curve, and fails in the way ``ending``, ``after_s`` seconds after its first tick.

    Before it fails, it notes the event in the file ``diary``, and uses up ``leaks``.
    """

    diary: str = ""
    ending: Literal["continue", "raise", "wait", "compute", "leak", "catch"] = "continue"
    leaks: Literal["nothing", "threads", "memory"] = "nothing"
    after_s: float = 1.0
    needs = frozenset({Role.DRIVE, Role.CAMERA})
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
                Diary(self.diary).note("event")
                if self.leaks != "nothing":
                    limit_address_space(64 << 20)
                    self._leak()
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
            Event().wait(HANG_S)
        while self.ending == "leak":
            self._leak()
        while True:  # "catch"
            with suppress(BaseException):
                Event().wait(HANG_S)

    def _leak(self) -> None:
        try:  # no `suppress`: making one takes memory
            LEAKS[self.leaks]()
        except MemoryError:
            return

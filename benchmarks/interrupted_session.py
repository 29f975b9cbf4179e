"""A session of `benchmarks.interruptions`: it drives a robot, and ends in one of several ways.

    python -m benchmarks.interrupted_session BACKEND WAY AFTER_S DIARY

``BACKEND`` is ``recording`` or ``raspberrypi``. The ways are the methods of `Session`.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import robotcore
from robotcore import LiveRobot, Role, Routine
from tests.drivers.raspberrypi.pwm.runs import ROBOT
from tests.drivers.raspberrypi.run_as_pi import PI_3
from tests.robotcore.safety.guardian.doubles import RecordingBackend
from tests.robotcore.safety.guardian.recorder import Diary

HOLD_US = 600_000
FAR_M = 50.0
EXIT_STATUS = 7


class Session:
    """Drives a robot for ``after_s`` seconds, notes the event in a diary, and then ends in the way of a method."""

    def __init__(self, robot: LiveRobot, after_s: float, diary: Diary) -> None:
        self._robot, self._after_s, self._diary = robot, after_s, diary

    def drive(self) -> None:
        """Drive until a signal comes."""
        self._robot.drive.straight(FAR_M)

    def raise_in_routine(self) -> None:
        self._drive_and(self._fail)

    def raise_in_condition(self) -> None:
        robot, end = self._robot, self._robot.clock.now() + self._after_s

        def is_over() -> bool:
            if robot.clock.now() > end:
                self._note()
                self._fail()
            return False

        robot.run(robotcore.race(robotcore.straight(robot, FAR_M), robotcore.wait_until(is_over)))

    def raise_between_calls(self) -> None:
        self._drive_and(lambda: None)
        self._fail()

    def end_without_close(self) -> None:
        self._drive_and(lambda: None)

    def exit_in_routine(self) -> None:
        self._drive_and(lambda: sys.exit(EXIT_STATUS))

    def hang(self) -> None:
        def spin() -> None:
            while True:
                pass

        self._drive_and(spin)

    def hold_lock(self) -> None:
        """Hold the interpreter lock, as a vendor's call may."""
        self._drive_and(lambda: ctypes.PyDLL(None).usleep(HOLD_US))

    def _drive_and(self, end: Callable[[], object]) -> None:
        def run() -> Routine[None]:
            drive, clock = self._robot.drive, self._robot.clock
            start = clock.now()
            while clock.now() - start < self._after_s:
                drive.set_velocity(0.2, 0.0)
                yield
            self._note()
            end()

        self._robot.run(run())

    def _note(self) -> None:
        self._diary.note("event")

    def _fail(self) -> None:
        raise RuntimeError("failed")


def main() -> None:
    """Open the robot, and execute the session of the command line. It does not close the robot."""
    backend, way, after_s, diary = sys.argv[1:]
    robot = "rover"
    if backend == "recording":
        double = RecordingBackend(Path(diary))
        for module in ("runtime.plan", "interactive.opening"):
            patch(f"robotcore.{module}.load_backend", lambda _: double).start()
    else:
        robot = str(ROBOT)
        patch("gpiozero.pins.local.get_pi_revision", lambda: PI_3).start()
    opened = robotcore.open(robot, backend, needs={Role.DRIVE})
    getattr(Session(opened, float(after_s), Diary(diary)), way)()


if __name__ == "__main__":
    main()

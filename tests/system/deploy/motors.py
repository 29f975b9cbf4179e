"""The log of the commands to the motors of the bench, read from the robot."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

from tests.system.deploy.machine import Machine
from tests.system.speed import scaled

FILE = "wheels.log"
LIMIT_S = 60.0
"""The time limit of `wait_for` on the reference machine, in s."""


class MotorCommand(NamedTuple):
    """A command in the log."""

    time_s: float
    """Time since boot."""
    process: int
    source: str
    """``app`` or ``cutoff``."""
    motor: str
    rad_s: float


class Motors:
    """The log of the motors since a mark."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._marked = 0

    def commands(self) -> list[MotorCommand]:
        """Return the commands since the mark, without a line that is still being written."""
        file = self._machine.home / FILE
        text = file.read_text() if file.exists() else ""
        lines = text[: text.rfind("\n") + 1].splitlines()
        rows = [line.split() for line in lines[self._marked :]]
        return [
            MotorCommand(float(at), int(process), source, motor, float(rad_s))
            for at, process, source, motor, rad_s in rows
        ]

    def mark(self) -> None:
        """Set the mark to the end of the log."""
        self._marked = 0
        self._marked = len(self.commands())

    def await_driving(self, rad_s: float = 2.0, instead_of: int = 0) -> int:
        """Wait until one process drives both motors at this velocity; return the process.

        instead_of: a process that does not count.
        """

        def read() -> int | None:
            process = self._driving(rad_s)
            return process if process != instead_of else None

        return wait_for(read, f"both motors at {rad_s:g} rad/s", lambda: self.commands()[-20:])

    def are_driven(self, rad_s: float) -> bool:
        """Wait until both motors are driven at this velocity; return whether that happened within the limit."""
        try:
            return bool(self.await_driving(rad_s))
        except AssertionError:
            return False

    def are_stopped(self) -> bool:
        """Return whether the last command of each motor is 0."""
        last = {command.motor: command.rad_s for command in self.commands()}
        return bool(last) and not any(last.values())

    def were_stopped_between(self, first: int, second: int) -> bool:
        """Return whether both motors were stopped between the last command of one process and the first of another."""
        found = self.commands()
        drove = max(at for at, each in enumerate(found) if each.process == first and each.rad_s)
        drives = min(at for at, each in enumerate(found) if each.process == second and each.rad_s)
        return {each.motor for each in found[drove:drives] if not each.rad_s} == {"left_motor", "right_motor"}

    def _driving(self, rad_s: float) -> int | None:
        last = {command.motor: command for command in self.commands()}
        processes = {command.process for command in last.values() if command.rad_s == rad_s}
        is_both = len(last) == 2 and all(command.rad_s == rad_s for command in last.values())
        return processes.pop() if is_both and len(processes) == 1 else None


def wait_for(read: Callable[[], int | None], name: str, describe: Callable[[], object]) -> int:
    """Wait until ``read`` returns a value, and return it; fail after `LIMIT_S`.

    name: the awaited state, for the error.
    describe: returns the present state, for the error.
    """
    ending = time.monotonic() + scaled(LIMIT_S)
    while (value := read()) is None:
        assert time.monotonic() < ending, f"waited for {name} in vain; the state is {describe()}"
        time.sleep(0.05)
    return value

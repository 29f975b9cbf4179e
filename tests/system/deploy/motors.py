"""What the bench's motors were told, as their file on the target says."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

from tests.system.deploy.machine import Machine
from tests.system.speed import scaled

FILE = "wheels.log"
LIMIT_S = 60.0
"""On the reference machine: a hang."""


class MotorCommand(NamedTuple):
    """A motor was told a velocity, in rad/s, at a time, in s since boot, by a process: the app, or what cuts it off."""

    time_s: float
    process: int
    who: str
    motor: str
    rad_s: float


class Motors:
    """The diary of the motors, and what of it is new since somebody marked a place in it."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._marked = 0

    def commands(self) -> list[MotorCommand]:
        """Return the commands since the mark. A line that the app is still writing is left for the next call."""
        file = self._machine.home / FILE
        text = file.read_text() if file.exists() else ""
        lines = text[: text.rfind("\n") + 1].splitlines()
        rows = [line.split() for line in lines[self._marked :]]
        return [
            MotorCommand(float(at), int(process), who, motor, float(rad_s)) for at, process, who, motor, rad_s in rows
        ]

    def mark(self) -> None:
        """Begin anew here."""
        self._marked = 0
        self._marked = len(self.commands())

    def await_driving(self, rad_s: float = 2.0, instead_of: int = 0) -> int:
        """Wait until both motors are driven at this velocity, by another process if so asked; return by which one."""

        def look() -> int | None:
            process = self._driving(rad_s)
            return process if process != instead_of else None

        return awaited(look, f"both motors at {rad_s:g} rad/s", lambda: self.commands()[-20:])

    def come_to_be_driven(self, rad_s: float) -> bool:
        """Whether both motors are driven at this velocity, if need be after a while."""
        try:
            return bool(self.await_driving(rad_s))
        except AssertionError:
            return False

    def is_still(self) -> bool:
        """Whether the last that each motor was told is to stand."""
        last = {command.motor: command.rad_s for command in self.commands()}
        return bool(last) and not any(last.values())

    def stood_between(self, first: int, second: int) -> bool:
        """Whether both motors were made to stand after one process last drove them, and before another first did."""
        found = self.commands()
        drove = max(at for at, each in enumerate(found) if each.process == first and each.rad_s)
        drives = min(at for at, each in enumerate(found) if each.process == second and each.rad_s)
        return {each.motor for each in found[drove:drives] if not each.rad_s} == {"left_motor", "right_motor"}

    def _driving(self, rad_s: float) -> int | None:
        last = {command.motor: command for command in self.commands()}
        processes = {command.process for command in last.values() if command.rad_s == rad_s}
        is_both = len(last) == 2 and all(command.rad_s == rad_s for command in last.values())
        return processes.pop() if is_both and len(processes) == 1 else None


def awaited(look: Callable[[], int | None], what: str, otherwise: Callable[[], object]) -> int:
    """Return what is seen, once it is; a check that waits in vain fails, and tells what there was instead."""
    ending = time.monotonic() + scaled(LIMIT_S)
    while (seen := look()) is None:
        assert time.monotonic() < ending, f"waited for {what} in vain; there was {otherwise()}"
        time.sleep(0.05)
    return seen

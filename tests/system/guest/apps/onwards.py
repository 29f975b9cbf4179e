"""Drives on and on: what is running when a process is told to end, or is ended."""

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status


@dataclass
class Onwards(Behaviour):
    """Never ends by itself."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.2, 0.0)
        return Status.RUNNING

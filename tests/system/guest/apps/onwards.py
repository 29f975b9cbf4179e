"""Drives on and on: what is running when a process is told to end, or is ended."""

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status


@dataclass
class Onwards(Behaviour):
    """Never ends by itself."""

    needs = frozenset({Role.DRIVE})

    speed_m_s: float = 0.2

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(self.speed_m_s, 0.0)
        return Status.RUNNING

"""An app that drives without end, for checks that end its process."""

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status


@dataclass
class EndlessDrive(Behaviour):
    """Drives forward without end."""

    needs = frozenset({Role.DRIVE})

    speed_m_s: float = 0.2

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(self.speed_m_s, 0.0)
        return Status.RUNNING

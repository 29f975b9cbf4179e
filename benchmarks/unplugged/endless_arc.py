"""An app that drives in a wide arc without an end."""

from __future__ import annotations

from robotcore import Behaviour, Robot, Role, Status


class EndlessArc(Behaviour):
    """Drives in a wide arc until the run is stopped."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.15, 0.3)
        self.state = "driving"
        return Status.RUNNING

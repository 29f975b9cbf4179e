"""An app that drives in wide arcs without an end."""

from __future__ import annotations

from robotcore import Behaviour, Robot, Role, Status


class On(Behaviour):
    """Drives in wide arcs."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.15, 0.3)
        self.state = "driving"
        return Status.RUNNING

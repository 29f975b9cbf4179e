"""Drives on with all that the bench has: what it sees and hears, and how far its wheels say that it came."""

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status


@dataclass
class Tour(Behaviour):
    """Ends where a picture has arrived and the way is driven."""

    distance_m: float = 0.2

    needs = frozenset({Role.DRIVE, Role.RANGE, Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        robot.range.read()
        picture = robot.camera.read().image
        if not picture.any():
            return Status.FAILURE
        robot.drive.set_velocity(0.1, 0.0)
        return Status.SUCCESS if robot.drive.pose.x >= self.distance_m else Status.RUNNING

"""An app that uses all devices of the bench: motors, encoders, range sensor and camera."""

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status


@dataclass
class Tour(Behaviour):
    """Drives a distance by the encoders; fails if a picture is black."""

    distance_m: float = 0.2

    needs = frozenset({Role.DRIVE, Role.RANGE, Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        robot.range.read()
        picture = robot.camera.read().image
        if not picture.any():
            return Status.FAILURE
        robot.drive.set_velocity(0.1, 0.0)
        return Status.SUCCESS if robot.drive.pose.x >= self.distance_m else Status.RUNNING

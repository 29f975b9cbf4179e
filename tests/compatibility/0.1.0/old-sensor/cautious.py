from robotcore import Behaviour, Robot, Role, Status
from old_sensor import OldSensor


class Cautious(Behaviour):
    """Drives ahead until the robot is as fast as commanded."""

    needs = {Role.DRIVE, OldSensor}

    def step(self, robot: Robot) -> Status:
        (flow,) = robot.all(OldSensor)
        robot.drive.set_velocity(0.2, 0.0)
        if flow.read().speed < 0.19:
            return Status.RUNNING
        self.reason = f"{flow.read().speed:.2f} m/s"
        return Status.SUCCESS

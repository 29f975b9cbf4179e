"""An app that drives an arc and reads the sensor ``flow`` of the robot of `robotcore new --kind`."""

from typing import ClassVar

from robotcore import Behaviour, Robot, Role, Status
from robotcore.hal.device import Sensor


class SensorReader(Behaviour):
    """Drives an arc, and reads a sensor of any kind."""

    needs: ClassVar = {Role.DRIVE, "flow"}

    def step(self, robot: Robot) -> Status:
        sensor = robot["flow"]
        assert isinstance(sensor, Sensor)
        self.state = str(sensor.read())
        robot.drive.set_velocity(0.2, 0.2)
        return Status.RUNNING

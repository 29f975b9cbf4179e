"""Stand until a person drives, by the operator of the run or by the robot's gamepad."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from robotcore import Behaviour, Interval, Robot, Role, Status
from robotcore.kinds import Bumper, Button, Buzzer, Camera, Gamepad, Imu, Led, Lidar, LineSensor, RangeSensor, Servo
from robotcore.runtime.hand_driving import read_sensors


@dataclass
class Teleop(Behaviour):
    """Stands until a person drives. The left stick of a gamepad drives forward and back, the right stick turns."""

    speed: Annotated[float, Interval(gt=0, le=1)] = 0.5
    """The velocity at the end of a stick, as a ratio to the greatest one."""

    needs = frozenset({Role.DRIVE})
    wants = frozenset({Bumper, Button, Buzzer, Camera, Gamepad, Imu, Led, Lidar, LineSensor, RangeSensor, Servo})

    def step(self, robot: Robot) -> Status:
        read_sensors(robot)
        linear = angular = 0.0
        for gamepad in robot.all(Gamepad):
            pad = gamepad.read()
            linear, angular = linear + pad.left_y, angular - pad.right_x
        self.state = "drive" if linear or angular else "stand"
        drive = robot.drive
        drive.set_velocity(self.speed * linear * drive.max_linear, self.speed * angular * drive.max_angular / 2)
        return Status.RUNNING


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("teleop")

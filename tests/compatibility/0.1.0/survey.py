"""An app that reads every sensor and commands every actuator of any robot. It logs values and prints."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robotcore import Behaviour, Robot, Role, Status
from robotcore.errors import DeviceError
from robotcore.hal.device import Device
from robotcore.kinds import (
    Battery,
    Bumper,
    Button,
    Buzzer,
    Camera,
    Display,
    Encoder,
    Gamepad,
    Imu,
    Led,
    Lidar,
    LineSensor,
    RangeSensor,
    Servo,
)


@dataclass
class Survey(Behaviour):
    """Drives in a curve for ``duration_s``, and ends as ``ending`` says."""

    duration_s: float = 2.0
    ending: Literal["success", "failure", "exception", "nan"] = "success"
    needs = frozenset({Role.DRIVE})
    wants = frozenset[type[Device] | str](
        (
            *(Battery, Bumper, Button, Camera, Encoder, Gamepad, Imu, Lidar, LineSensor, RangeSensor),
            *(Buzzer, Display, Led, Servo),
        )
    )
    milestones = ("begun", "half")

    def step(self, robot: Robot) -> Status:
        now = robot.clock.now()
        if not self._read_all(robot):
            self.state = "blind"
        else:
            self.state = "begun" if now < self.duration_s / 2 else "half"
        robot.drive.set_velocity(0.15, 0.3)
        for servo in robot.all(Servo):
            if servo.name != "steering":
                servo.set_angle(0.5 if now < 1.0 else -0.5)
        for lamp in robot.all(Led):
            lamp.set_colour(1.0, 0.5, 0.0)
        for horn in robot.all(Buzzer):
            horn.play(440.0 if now < 0.5 else 0.0)
        if now < self.duration_s:
            return Status.RUNNING
        return self._end(robot)

    def _read_all(self, robot: Robot) -> bool:
        samples = {}
        for device in robot.devices.values():
            if hasattr(device, "read"):
                try:
                    samples[device.name] = device.read()
                except DeviceError:
                    return False
        for camera in robot.all(Camera):
            picture = samples[camera.name].image
            robot.log("brightness", float(np.mean(picture)))
            for display in robot.all(Display):
                display.show(picture)
        robot.log("time", robot.clock.now(), "s")
        robot.log("is_late", robot.clock.now() > self.duration_s / 2)
        robot.log("state", self.state)
        return True

    def _end(self, robot: Robot) -> Status:
        print("the end")  # noqa: T201  a recording has what an app prints
        if self.ending == "nan":
            robot.drive.set_velocity(float("nan"), 0.0)
        if self.ending == "exception":
            raise RuntimeError("as asked")
        self.reason = f"the ending is {self.ending}"
        return Status.FAILURE if self.ending == "failure" else Status.SUCCESS

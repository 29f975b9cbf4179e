"""The kinematic world, in which the wheels of the simulated board move the robot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from threading import RLock

from drivers.kinematic.devices import Sonar
from drivers.kinematic.simulation import Simulation
from robotcore.description import RobotDescription
from robotcore.geometry import Pose, Twist, Wheels
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock
from robotcore.hal.sampling import SampleCache
from robotcore.kinds.camera import Camera, CameraDescription, Frame
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.optics import CameraView, Image
from tests.system.firmware.simulated import SimulatedRobot

STEPS_PER_S = 240
"""The rate of the simulation's steps in Hz."""

SONAR_RANGE_M = 4.0
"""The range of an HC-SR04 in metres."""


class FollowedWorld:
    """Moves the robot's body by the wheels of a simulated board, and sets the distance that its sonar measures.

    It is the run's `TruthSource`. Any thread may call it.
    """

    def __init__(self, setup: Setup, simulated: SimulatedRobot) -> None:
        assert setup.world
        self._simulation = Simulation(replace(setup, robot=_without_lag(setup.robot), rate_hz=STEPS_PER_S), setup.world)
        self._drive, self._simulated = setup.robot.drive, simulated
        self._angles, self._at = simulated.angles, simulated.now()
        self._lock = RLock()
        self._drops_echoes = False
        nose = setup.robot.first_of(RangeSensorDescription)
        self._sonar = nose and Sonar(nose.model_copy(update={"max_range_m": SONAR_RANGE_M}), setup.world)
        self.follow()

    def follow(self) -> None:
        """Move the body by the turns of the wheels since the last call, on one arc. So it must be called often."""
        with self._lock:
            angles, now = self._simulated.angles, self._simulated.now()
            self._roll(angles, max(1, math.ceil((now - self._at) * STEPS_PER_S)))
            self._angles, self._at = angles, now
            if self._sonar:
                self._simulated.place_target(self._measure_ahead(self._sonar))

    def drop_echoes(self) -> None:
        """Drop all echoes from now on."""
        self._drops_echoes = True
        self.follow()

    def pose(self) -> Pose:
        with self._lock:
            self.follow()
            return self._simulation.pose()

    def twist(self) -> Twist:
        return self._drive.geometry.to_twist(self._simulated.velocities) if self._drive else Twist(0.0, 0.0)

    def contacts(self) -> int:
        with self._lock:
            return self._simulation.contacts()

    def picture(self, view: Callable[[Pose], CameraView]) -> Image:
        """Return the picture that a camera of the robot sees."""
        return self._simulation.painter.picture(view(self.pose()))

    def _measure_ahead(self, sonar: Sonar) -> float:
        return math.inf if self._drops_echoes else sonar.measure(self._simulation.pose()).distance

    def _roll(self, to: Wheels, steps: int) -> None:
        if not self._drive:
            return
        clock, wheels = self._simulation.clock, self._simulation.wheels
        for name, turn in (
            (self._drive.left_motors[0], to.left - self._angles.left),
            (self._drive.right_motors[0], to.right - self._angles.right),
        ):
            wheels[name].target = turn / steps / clock.step
        clock.sleep_until(clock.now() + steps * clock.step)


class FollowedCamera(Camera):
    """A camera that shows the kinematic world at the time of reading."""

    def __init__(self, description: CameraDescription, world: FollowedWorld, clock: Clock) -> None:
        super().__init__(description.name, description.intrinsics)
        self._mount, self._world = description.mount, world
        self._newest_at = SampleCache(clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        image = self._world.picture(lambda pose: CameraView.of(self.intrinsics, self._mount, pose))
        image.flags.writeable = False
        return Frame(image, time, sequence)


def _without_lag(robot: RobotDescription) -> RobotDescription:
    """Return the robot without lags of its wheels, because the simulated board's wheels have the lag."""
    devices = (
        description.model_copy(update={"lag_s": 0.0}) if isinstance(description, MotorDescription) else description
        for description in robot.devices
    )
    return robot.model_copy(update={"devices": tuple(devices)})

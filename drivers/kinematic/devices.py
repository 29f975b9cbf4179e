"""The devices of a simulated robot: each looks at the simulation at the instant it is read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.kinematic.motion import Wheel
from drivers.kinematic.simulation import Simulation
from robotcore.description import (
    CameraDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    WorldDescription,
)
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Camera, Encoder, Frame, Image, Motor, Range, RangeSensor
from robotcore.optics import CameraView
from robotcore.raycast import FAN_SETBACK_M, Fan, cast, edges_of
from robotcore.simulation.sampling import SampleCache


class KinematicMotor(Motor):
    """Sets the velocity that a wheel lags behind."""

    def __init__(self, description: MotorDescription, wheel: Wheel) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._wheel = wheel

    def _apply(self, rad_s: float) -> None:
        self._wheel.target = rad_s


class KinematicEncoder(Encoder):
    """Reads a wheel's angle in whole counts."""

    def __init__(self, description: EncoderDescription, wheel: Wheel, clock: Clock) -> None:
        super().__init__(description.name)
        self._wheel = wheel
        self._quantise = description.quantise
        self._newest_at = SampleCache(clock, self._read_wheel)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _read_wheel(self, time: float, sequence: int) -> Angle:
        return Angle(self._quantise(self._wheel.angle), time, sequence)


class KinematicRangeSensor(RangeSensor):
    """Listens with a fan of rays."""

    def __init__(self, description: RangeSensorDescription, simulation: Simulation) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._sonar = Sonar(description, simulation.world)
        self._simulation = simulation
        self._newest_at = SampleCache(simulation.clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        distance, point = self._sonar.listen(self._simulation.pose())
        return Range(distance, time, sequence, point)


class KinematicCamera(Camera):
    """Paints a picture when it is read, never otherwise."""

    def __init__(self, description: CameraDescription, simulation: Simulation) -> None:
        super().__init__(description.name, description.intrinsics)
        self._mount = description.mount
        self._simulation = simulation
        self._newest_at = SampleCache(simulation.clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        view = CameraView.of(self.intrinsics, self._mount, self._simulation.pose())
        image: Image = self._simulation.painter.picture(view)
        image.flags.writeable = False
        return Frame(image, time, sequence)


Array = NDArray[np.float64]
Point = tuple[float, float, float]


class Echo(NamedTuple):
    """A distance in metres, and in the sensor's frame the point that it comes from, if any."""

    distance: float
    point: Point | None


class Sonar:
    """Casts a sensor's fan at whatever of the world stands as high as the sensor."""

    def __init__(self, sensor: RangeSensorDescription, world: WorldDescription) -> None:
        mount = sensor.mount
        self._mount = Pose(mount.x_m, mount.y_m, mount.yaw_rad)
        self._fan = Fan(sensor.cone_rad, sensor.min_range_m, sensor.max_range_m)
        self._edges = edges_of(prism.outline for prism in world.prisms if prism.height_m > mount.z_m)
        self._circles = np.array(
            [(ball.x_m, ball.y_m, ball.radius_m**2 - (mount.z_m - ball.radius_m) ** 2) for ball in world.targets]
        ).reshape(-1, 3)

    def listen(self, robot: Pose) -> Echo:
        """Return what the sensor hears on a robot at ``robot``."""
        sensor = robot.moved(self._mount)
        x, y = sensor.to_world(-FAN_SETBACK_M, 0.0)
        dx, dy = self._fan.directions(sensor)
        lengths = np.minimum(cast(x, y, dx, dy, self._edges), cast_at_circles(x, y, dx, dy, self._circles))
        return Echo(self._fan.reading(lengths), self._fan.point(lengths))


def cast_at_circles(x: float, y: float, dx: Array, dy: Array, circles: Array) -> Array:
    """Return for each ray of unit direction, (n,), the distance to the first circle; ``inf`` if none.

    ``circles`` are (m, 3): centre, and radius squared; one below zero is never hit.
    """
    to_x, to_y = circles[:, 0] - x, circles[:, 1] - y
    along = np.outer(dx, to_x) + np.outer(dy, to_y)
    beside = np.outer(dx, to_y) - np.outer(dy, to_x)
    half_chord = np.sqrt(np.maximum(circles[:, 2] - beside**2, 0.0))
    hit = (beside**2 <= circles[:, 2]) & (along >= half_chord)
    nearest: Array = np.where(hit, along - half_chord, math.inf).min(axis=1, initial=math.inf)
    return nearest

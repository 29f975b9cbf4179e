"""The devices of a simulated robot: each looks at the simulation at the instant it is read."""

from __future__ import annotations

from drivers.kinematic.echo import Sonar
from drivers.kinematic.motion import Wheel
from drivers.kinematic.simulation import Simulation
from robotcore.description import (
    CameraDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
)
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Camera, Encoder, Frame, Image, Motor, Range, RangeSensor
from robotcore.optics import View
from robotcore.simulation.sampling import OnceAnInstant


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
        self._quantised = description.quantised
        self._newest_at = OnceAnInstant(clock, self._read_wheel)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _read_wheel(self, time: float, sequence: int) -> Angle:
        return Angle(self._quantised(self._wheel.angle), time, sequence)


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
        self._newest_at = OnceAnInstant(simulation.clock, self._listen)

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
        self._newest_at = OnceAnInstant(simulation.clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        view = View.of(self.intrinsics, self._mount, self._simulation.pose())
        image: Image = self._simulation.painter.picture(view)
        image.flags.writeable = False
        return Frame(image, time, sequence)

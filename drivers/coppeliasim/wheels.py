"""The wheels of a robot that was built: a motor with a lag, an encoder that counts on and on."""

from __future__ import annotations

import math

from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.description import EncoderDescription, MotorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Encoder, Motor
from robotcore.simulation.sampling import OnceAnInstant


class BuiltMotor(Motor):
    """A joint, told a velocity that lags behind the one asked for.

    A step h of the simulator's may be as long as the lag τ, so it is told the mean of what the lag lets through in it:
    what is missing, times 1 - τ/h·(1 - exp(-h/τ)).
    """

    def __init__(self, scene: CoppeliaSimScene, description: MotorDescription, joint: int, step: float) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._scene, self._joint = scene, joint
        lag = description.lag_s
        self._through = -math.expm1(-step / lag) if lag else 1.0
        self._mean = 1 - lag / step * self._through
        self._asked = self._velocity = self._sent = 0.0

    def drive(self) -> None:
        """Tell the joint how it turns in the step that comes."""
        missing = self._asked - self._velocity
        self._send(self._velocity + missing * self._mean)
        self._velocity += missing * self._through

    def _apply(self, rad_s: float) -> None:
        self._asked = rad_s

    def _send(self, rad_s: float) -> None:
        if rad_s != self._sent:
            self._scene.set_joint_velocity(self._joint, rad_s)
            self._sent = rad_s


class BuiltEncoder(Encoder):
    """Whole counts of a wheel's joint."""

    def __init__(self, scene: CoppeliaSimScene, description: EncoderDescription, joint: int, clock: Clock) -> None:
        super().__init__(description.name)
        self._scene, self._description, self._joint = scene, description, joint
        self._zero = scene.joint_position(joint)
        self._newest_at = OnceAnInstant(clock, self._count)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        angle = self._scene.joint_position(self._joint) - self._zero
        return Angle(self._description.quantised(angle), time, sequence)

"""Motors and encoders of the wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.mujoco.body import Body
from robotcore.description import EncoderDescription, MotorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Encoder, Motor
from robotcore.simulation.sampling import OnceAnInstant

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class MujocoMotor(Motor):
    """The rotor that drives a wheel; lag and torque are the model's."""

    def __init__(self, model: MjModel, data: MjData, description: MotorDescription, body: Body) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        body.joint_of(self.name)
        self._controls, self._number = data.ctrl, model.actuator(self.name).id

    def _apply(self, rad_s: float) -> None:
        self._controls[self._number] = rad_s


class MujocoEncoder(Encoder):
    """Whole counts of a wheel's joint."""

    def __init__(self, description: EncoderDescription, clock: Clock, body: Body) -> None:
        super().__init__(description.name)
        self._description, self._body = description, body
        self._joint = body.joint_of(self.name)
        self._newest_at = OnceAnInstant(clock, self._count)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        return Angle(self._description.quantised(self._body.angle(self._joint)), time, sequence)

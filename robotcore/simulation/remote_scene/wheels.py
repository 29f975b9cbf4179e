"""A joint of a scene as a wheel's motor, and as its encoder."""

from __future__ import annotations

import math
from threading import Lock

from robotcore.description import EncoderDescription, MotorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Encoder, Motor
from robotcore.simulation.remote_scene.port import Scene
from robotcore.simulation.sampling import OnceAnInstant


class SceneMotor(Motor):
    """Gives a joint its target velocity; ``is_reversed`` where the joint turns the other way round."""

    def __init__(self, description: MotorDescription, scene: Scene, joint: int, *, is_reversed: bool) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._scene, self._joint = scene, joint
        self._sign = -1.0 if is_reversed else 1.0

    def _apply(self, rad_s: float) -> None:
        self._scene.set_joint_velocity(self._joint, float(self._sign * rad_s))  # never a type of NumPy's


class SceneEncoder(Encoder):
    """Whole counts of a joint's angle since the robot was opened.

    The server tells no turns: a joint that passes π is at -π. So the angle is looked at every ``period`` seconds, in
    which no wheel may turn by half a turn.
    """

    def __init__(
        self,
        description: EncoderDescription,
        scene: Scene,
        joint: int,
        clock: Clock,
        period: float,
        *,
        is_reversed: bool,
    ) -> None:
        super().__init__(description.name)
        self._position = scene.joint_position
        self._joint, self._sign = joint, -1.0 if is_reversed else 1.0
        self._quantised = description.quantised
        self._turned, self._seen = 0.0, self._position(joint)
        self._lock = Lock()
        self._newest_at = OnceAnInstant(clock, self._count)
        self._looking = clock.every(period, self._newest, self.name)

    def _newest(self) -> Angle:
        with self._lock:
            return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        seen = self._position(self._joint)
        self._turned += math.remainder(seen - self._seen, math.tau)
        self._seen = seen
        return Angle(self._quantised(self._sign * self._turned), time, sequence)

    def _release(self) -> None:
        self._looking.stop()

"""The physics steps of Bullet, which include the motors and the count of contacts."""

from __future__ import annotations

import math
from collections.abc import Collection

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from robotcore.description import MotorDescription
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Motor
from robotcore.hal.truth import RELEASE_M


class Physics:
    """The physics of a simulation: a stepped clock whose steps are physics steps of Bullet."""

    def __init__(self, bullet: Bullet, rate_hz: float, contacts: ContactCounter, solver_iterations: int) -> None:
        self.clock = SteppedClock(rate_hz, self._advance)
        self.motors: list[BulletMotor] = []
        self._step = bullet.stepSimulation
        self._contacts = contacts
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.clock.step,
            numSolverIterations=solver_iterations,
            deterministicOverlappingPairs=1,
        )
        bullet.setGravity(0.0, 0.0, -9.81)

    def _advance(self, steps: int) -> None:
        for _ in range(steps):
            for motor in self.motors:
                motor.drive()
            self._step()
            self._contacts.update()


class BulletMotor(Motor):
    """A motor of a wheel. The velocity of the wheel's joint follows the command with a first-order lag.

    In a step of h seconds, a lag τ reduces the difference between velocity and command by the fraction 1 - exp(-h/τ).
    """

    def __init__(self, bullet: Bullet, description: MotorDescription, body: Body, step: float) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._control = bullet.setJointMotorControl2
        self._body, self._joint = body.body_id, body.find_joint(self.name)
        self._velocity_control = bullet.VELOCITY_CONTROL
        self._torque = description.max_torque_nm
        self._gain = -math.expm1(-step / description.lag_s) if description.lag_s else 1.0
        self._command = self._velocity = 0.0
        self._send()

    def drive(self) -> None:
        """Set the target velocity of the joint for the next physics step."""
        before = self._velocity
        self._velocity += (self._command - before) * self._gain
        if self._velocity != before:
            self._send()

    def _apply(self, rad_s: float) -> None:
        self._command = rad_s

    def _send(self) -> None:
        self._control(
            self._body, self._joint, self._velocity_control, targetVelocity=self._velocity, force=self._torque
        )


class ContactCounter:
    """Counts the contacts of the robot's body with other bodies, except the floor.

    A contact counts once, even if it lasts for many steps.
    """

    def __init__(self, bullet: Bullet, body: int, things: Collection[int]) -> None:
        self.count = 0
        self._contact_points = bullet.getContactPoints
        self._body = body
        self._things = frozenset(things)
        self._touched: set[int] = set()

    def update(self) -> None:
        """Count the contacts that began in the last physics step.

        Bullet also lists bodies that are near but do not touch. Their gap is greater than 0. A contact begins when the
        gap becomes 0 or less, and ends when the gap exceeds `RELEASE_M`.
        """
        points = self._contact_points(bodyA=self._body, linkIndexA=-1)
        if not (points or self._touched):  # usual case; the code below takes longer than the call of Bullet
            return
        gaps: dict[int, float] = {}
        for _, _, thing, _, _, _, _, _, gap, *_ in points:
            if thing in self._things:
                gaps[thing] = min(gap, gaps.get(thing, gap))
        begun = {thing for thing, gap in gaps.items() if gap <= 0} - self._touched
        self._touched = begun | {thing for thing in self._touched if gaps.get(thing, math.inf) <= RELEASE_M}
        self.count += len(begun)

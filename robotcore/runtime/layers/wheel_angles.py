"""The angles of a drive's two wheels, from encoders, from commands, and from the steering angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.drive import CommandIntegrator
from robotcore.hal.joint import Joint
from robotcore.kinds.encoder import Encoder


def read_angles(left: Sequence[Encoder], right: Sequence[Encoder]) -> Wheels:
    """Return the mean angles that the encoders of each side have measured, in radians."""
    return Wheels(
        sum(each.read().angle for each in left) / len(left), sum(each.read().angle for each in right) / len(right)
    )


def read_present_angles(left: Sequence[Encoder], right: Sequence[Encoder], commanded: CommandIntegrator) -> Wheels:
    """Return the mean of the present angles of each side in radians.

    The present angle is the encoder's angle plus the rotation that was commanded since the sample was captured.
    """
    lefts, rights = [each.read() for each in left], [each.read() for each in right]
    return Wheels(
        sum(each.angle + commanded.rotation_since(each.time).left for each in lefts) / len(lefts),
        sum(each.angle + commanded.rotation_since(each.time).right for each in rights) / len(rights),
    )


class SteeredAngles:
    """Computes the angles of two rear wheels from their mean angle and the motion of the servo that steers.

    read: a function that returns angles in radians, of which only the mean counts.
    joint: the motion of the servo.
    ratio: half of the distance between the wheels, divided by the distance between the axles.
    """

    def __init__(self, read: Callable[[], Wheels], joint: Joint, clock: Clock, ratio: float) -> None:
        self._read, self._joint, self._clock, self._ratio = read, joint, clock, ratio
        self._since, self._mean = clock.now(), 0.0
        self._angles = Wheels(0.0, 0.0)

    def __call__(self) -> Wheels:
        """Return the present angles of the rear wheels in radians."""
        left, right = self._read()
        mean, now = (left + right) / 2, self._clock.now()
        turned = mean - self._mean
        shift = turned * self._ratio * self._joint.mean_tangent(self._since, now)
        self._angles = Wheels(self._angles.left + turned - shift, self._angles.right + turned + shift)
        self._since, self._mean = now, mean
        return self._angles

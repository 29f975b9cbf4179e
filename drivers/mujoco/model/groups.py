"""Who meets whom, and who is seen by what."""

from __future__ import annotations

from collections.abc import Collection
from enum import IntEnum, IntFlag


class Meets(IntFlag):
    """Bits of contype and conaffinity: two geoms meet where one's type is among what the other has an affinity for."""

    NOTHING = 0
    FLOOR = 1
    THING = 2


class Shown(IntEnum):
    """Geom groups. Cameras on a robot see the world alone, its range sensors what stands in it."""

    FLOOR = 0
    WORLD = 1
    ROBOT = 2
    TOUCHED_THING = 3
    TOUCHED_ROBOT = 4


SEEN = frozenset({Shown.FLOOR, Shown.WORLD})
"""What a camera on the robot sees: neither the robot, nor shapes that are only touched."""

HEARD = frozenset({Shown.TOUCHED_THING})
"""What a range sensor hears: neither the robot nor the floor."""


def flags(groups: Collection[Shown]) -> list[bool]:
    """Return for each of MuJoCo's geom groups whether it is one of these."""
    from mujoco import mjNGROUP

    return [group in groups for group in range(mjNGROUP)]

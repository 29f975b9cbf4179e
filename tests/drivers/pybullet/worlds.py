"""Opens robots for the tests of this backend."""

from __future__ import annotations

from drivers.pybullet.backend import PyBulletBackend
from robotcore.description import RobotDescription, Start
from robotcore.hal.robot import Robot
from tests.drivers.physics.worlds import ROVER, Thing, setup, world


def opened(*things: Thing, start: Start | None = None, robot: RobotDescription = ROVER) -> Robot:
    """Return an open robot with all its devices in a world of these things."""
    return PyBulletBackend().open(setup(world(*things, start=start), robot=robot))

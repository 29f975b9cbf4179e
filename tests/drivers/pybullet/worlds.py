"""How the tests of this backend open a robot."""

from __future__ import annotations

from drivers.pybullet.backend import PyBulletBackend
from robotcore.description import RobotDescription, Start
from robotcore.hal.robot import Robot
from tests.drivers.physics.worlds import ROVER, Thing, setup, world


def opened(*things: Thing, start: Start | None = None, robot: RobotDescription = ROVER) -> Robot:
    """Open a robot with all its devices among these things."""
    return PyBulletBackend().open(setup(world(*things, start=start), robot=robot))

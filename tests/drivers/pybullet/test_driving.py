from __future__ import annotations

from drivers.pybullet.backend import PyBulletBackend
from tests.drivers.physics import driving


class TestDriving(driving.Driving):
    backend = PyBulletBackend

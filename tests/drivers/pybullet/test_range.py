from __future__ import annotations

from drivers.pybullet.backend import PyBulletBackend
from tests.drivers.physics import ranging


class TestRanging(ranging.Ranging):
    backend = PyBulletBackend

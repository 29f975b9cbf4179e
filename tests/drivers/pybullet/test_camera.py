from __future__ import annotations

from drivers.pybullet.backend import PyBulletBackend
from tests.drivers.physics import seeing


class TestSeeing(seeing.Seeing):
    backend = PyBulletBackend

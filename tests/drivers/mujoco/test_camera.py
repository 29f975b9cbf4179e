from __future__ import annotations

from drivers.mujoco.backend import MujocoBackend
from tests.drivers.physics import seeing


class TestSeeing(seeing.Seeing):
    backend = MujocoBackend

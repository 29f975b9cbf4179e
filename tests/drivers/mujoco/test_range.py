from __future__ import annotations

from drivers.mujoco.backend import MujocoBackend
from tests.drivers.physics import ranging


class TestRanging(ranging.Ranging):
    backend = MujocoBackend

from __future__ import annotations

from drivers.mujoco.backend import MujocoBackend
from tests.drivers.physics import texturing


class TestTexturing(texturing.Texturing):
    backend = MujocoBackend

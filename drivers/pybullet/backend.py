"""The PyBullet backend: opens a robot in a Bullet simulation in this process."""

from __future__ import annotations

import platform
import sys
from contextlib import ExitStack

from pydantic import PositiveInt

from drivers.pybullet.bullet import Bullet, redirect_stdout
from drivers.pybullet.simulation import Simulation
from robotcore.errors import UsageError
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.robot import Robot
from robotcore.hardware import SimulatorBackend
from robotcore.simulation.body_cameras import CameraOptions


class PyBulletOptions(CameraOptions):
    """The options of the backend."""

    solver_iterations: PositiveInt = 50
    """The number of iterations of the contact solver in each physics step."""


class PyBulletBackend(SimulatorBackend):
    """Opens each robot in its own Bullet simulation. Equal runs on one platform give bit-identical results.

    `PyBulletOptions` describes the options.
    """

    name = "pybullet"
    summary = "Bullet rigid-body physics, in process"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    encoder_rate_hz = 120.0  # at 20 ticks a second, after every second step
    has_gui = True
    brings_physics = True
    modules = ("pybullet",)

    @property
    def remedy(self) -> str:
        if sys.version_info < (3, 12) and platform.machine() in ("x86_64", "AMD64"):
            return 'pip install "robotcore[sim]"'
        return (
            f"PyBullet has no wheel for Python {platform.python_version()} on {platform.machine()}. "
            "Use --backend mujoco, or Python 3.11 on an x86_64 machine"
        )

    def open(self, setup: Setup) -> Robot:
        if setup.world is None:
            raise UsageError("the backend 'pybullet' needs a world. Name one with --world", kind="world-missing")
        options = setup.options_as(PyBulletOptions)
        self.require_installed()
        with redirect_stdout(), ExitStack() as undo:
            bullet = Bullet.connect(gui=setup.gui)
            undo.callback(bullet.close)
            simulation = Simulation(bullet, setup, setup.world, options.solver_iterations, options.camera)
            devices = self.open_each(setup, simulation.clock, simulation.open)
            undo.pop_all()
        return Robot(setup.robot.name, simulation.clock, devices, truth=simulation, release=simulation.close)

"""MuJoCo's rigid-body physics, in this process."""

from __future__ import annotations

import os
from contextlib import ExitStack

from drivers.mujoco.simulation import Simulation
from robotcore.backend import Backend, Setup, Vouch
from robotcore.description import Described, RobotDescription, WorldDescription
from robotcore.errors import BackendError, UsageError
from robotcore.exporting import Exported
from robotcore.robot import Robot


class MujocoOptions(Described):
    """There are none."""


class MujocoBackend(Backend):
    """Opens each robot in a simulation of its own, reproducible to the bit on one platform."""

    name = "mujoco"
    summary = "MuJoCo rigid-body physics, in process: on every Python and on 64-bit ARM"
    vouches_for = frozenset({Vouch.CONTACTS, Vouch.POSE, Vouch.LOCKSTEP})
    needs_world = True
    has_gui = True
    brings_physics = True
    exports = ("mjcf",)
    modules = ("mujoco",)

    @property
    def remedy(self) -> str:
        return 'pip install "robotcore[sim]"'

    def open(self, setup: Setup) -> Robot:
        setup = setup.without_batteries()
        if setup.world is None:
            raise UsageError("the mujoco backend needs a world; name one with --world")
        setup.options_as(MujocoOptions)
        self.require_installed()
        _load()
        with ExitStack() as undo:
            simulation = Simulation(setup, setup.world)
            undo.callback(simulation.close)
            devices = setup.open_each(simulation.open)
            undo.pop_all()
        return Robot(setup.robot.name, simulation.clock, devices, truth=simulation.truth, release=simulation.close)

    def export(
        self, file_format: str, robot: RobotDescription, world: WorldDescription | None, folder: str | None
    ) -> Exported:
        from drivers.mujoco.mjcf import mjcf

        self.require_installed()
        return mjcf(robot, world, folder)


def _load() -> None:
    """Import MuJoCo; it also looks, whether or not anything will be drawn, for the OpenGL that MUJOCO_GL names."""
    try:
        import mujoco  # noqa: F401
    except Exception as error:
        named = os.environ.get("MUJOCO_GL")
        remedy = f"Unset MUJOCO_GL, which is {named!r}: what works is found" if named else "Install it again"
        raise BackendError(f"mujoco: it cannot be loaded: {error}. {remedy}") from error

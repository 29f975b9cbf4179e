"""The MuJoCo backend: opens a robot in a MuJoCo simulation in this process, and exports its model as MJCF."""

from __future__ import annotations

import os
from contextlib import ExitStack

from drivers.mujoco.simulation import Simulation
from robotcore.description import RobotDescription, WorldDescription
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.backend import Capability, ModelExport, Setup
from robotcore.hal.robot import Robot
from robotcore.hardware import SimulatorBackend
from robotcore.simulation.body_cameras import CameraOptions

MIN_VERSION = (3, 5)


class MujocoBackend(SimulatorBackend):
    """Opens each robot in its own MuJoCo simulation. Equal runs on one platform give bit-identical results.

    `CameraOptions` describes the options.
    """

    name = "mujoco"
    summary = "MuJoCo rigid-body physics, in process, on Python 3.10 to 3.13, also on 64-bit ARM"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    encoder_rate_hz = 120.0  # at 20 ticks a second, after every second step
    has_gui = True
    brings_physics = True
    exports = ("mjcf",)
    modules = ("mujoco",)

    @property
    def remedy(self) -> str:
        return 'pip install "robotcore[sim]"'

    def require_installed(self) -> None:
        """Raise BackendMissingError if MuJoCo is missing or too old, or cannot be imported.

        The import of MuJoCo initialises the OpenGL library that the environment variable MUJOCO_GL selects. An error of
        any class can occur, and becomes a BackendMissingError.
        """
        super().require_installed()
        try:
            import mujoco
        except Exception as error:
            text = " ".join(str(error).split())
            renderer = os.environ.get("MUJOCO_GL")
            remedy = (
                f"Unset MUJOCO_GL, which is {renderer!r}. robotcore then chooses a renderer that works"
                if renderer
                else "pip install --force-reinstall mujoco"
            )
            raise BackendMissingError(f"MuJoCo cannot be imported: {text}. {remedy}") from error
        if tuple(map(int, mujoco.__version__.split(".")[:2])) < MIN_VERSION:
            needed = "{}.{}".format(*MIN_VERSION)
            raise BackendMissingError(
                f'MuJoCo {mujoco.__version__} is too old. Upgrade it: pip install "mujoco>={needed}"',
                kind="library-too-old",
            )

    def open(self, setup: Setup) -> Robot:
        if setup.world is None:
            raise UsageError("the backend 'mujoco' needs a world. Name one with --world", kind="world-missing")
        options = setup.options_as(CameraOptions)
        self.require_installed()
        with ExitStack() as cleanup:
            simulation = Simulation(setup, setup.world, options.camera)
            cleanup.callback(simulation.close)
            devices = self.open_each(setup, simulation.clock, simulation.open)
            cleanup.pop_all()
        return Robot(
            setup.robot.name,
            simulation.clock,
            devices,
            truth=simulation,
            release=simulation.close,
            notes=simulation.cameras.notes,
        )

    def export(
        self, file_format: str, robot: RobotDescription, world: WorldDescription | None, folder: str | None
    ) -> ModelExport:
        from drivers.mujoco.mjcf_export import mjcf

        self.require_installed()
        return mjcf(robot, world, folder)

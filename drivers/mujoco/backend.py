"""The MuJoCo backend: opens a robot in a MuJoCo simulation in this process, and exports its model as MJCF."""

from __future__ import annotations

import os
from contextlib import ExitStack

from drivers.mujoco.devices import CameraSet, MujocoEncoder, MujocoMotor, MujocoRangeSensor
from drivers.mujoco.model import build, compile_model
from drivers.mujoco.physics import Body, MujocoTruth, Physics
from drivers.mujoco.window import Window
from robotcore.description import (
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    SimulatedDevice,
    StrictModel,
    WorldDescription,
)
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.backend import Backend, Capability, ModelExport, Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device, MemoryDisplay
from robotcore.hal.robot import Robot

OLDEST = (3, 5)


class MujocoOptions(StrictModel):
    """The options of the backend. It has none, so any option is refused."""


class MujocoBackend(Backend):
    """Opens each robot in its own MuJoCo simulation. Equal runs on one platform give bit-identical results."""

    name = "mujoco"
    summary = "MuJoCo rigid-body physics, in process, on Python 3.10 to 3.13, also on 64-bit ARM"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
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
        if tuple(map(int, mujoco.__version__.split(".")[:2])) < OLDEST:
            needed = "{}.{}".format(*OLDEST)
            raise BackendMissingError(
                f'MuJoCo {mujoco.__version__} is too old. Upgrade it: pip install "mujoco>={needed}"',
                kind="library-too-old",
            )

    def open(self, setup: Setup) -> Robot:
        setup = setup.without_batteries()
        if setup.world is None:
            raise UsageError("the backend 'mujoco' needs a world. Name one with --world", kind="world-missing")
        setup.options_as(MujocoOptions)
        self.require_installed()
        with ExitStack() as cleanup:
            simulation = Simulation(setup, setup.world)
            cleanup.callback(simulation.close)
            devices = setup.open_each(simulation.open)
            cleanup.pop_all()
        return Robot(setup.robot.name, simulation.clock, devices, truth=simulation.truth, release=simulation.close)

    def export(
        self, file_format: str, robot: RobotDescription, world: WorldDescription | None, folder: str | None
    ) -> ModelExport:
        from drivers.mujoco.mjcf_export import mjcf

        self.require_installed()
        return mjcf(robot, world, folder)


class Simulation:
    """A MuJoCo simulation of one robot in one world, and its devices."""

    def __init__(self, setup: Setup, world: WorldDescription) -> None:
        self._physics = Physics(setup.rate_hz, lambda step: compile_model(build(setup.robot, world, step)))
        self.model, self.data = self._physics.model, self._physics.data
        self._body = Body(self.model, self.data, setup.robot)
        self._cameras = CameraSet(self.model, self.data, world)
        self.truth = MujocoTruth(self._body, self._physics)
        self._closing = ExitStack()
        self._closing.callback(self._cameras.close)
        if setup.gui:
            self._open_window(max(world.floor.length_m, world.floor.width_m))

    @property
    def clock(self) -> SteppedClock:
        return self._physics.clock

    def open(self, description: SimulatedDevice) -> Device:
        """Open a device of the robot. Raises DeviceError for a motor or an encoder that is on no wheel."""
        if isinstance(description, MotorDescription):
            return MujocoMotor(self.model, self.data, description, self._body)
        if isinstance(description, EncoderDescription):
            return MujocoEncoder(description, self.clock, self._body)
        if isinstance(description, RangeSensorDescription):
            return MujocoRangeSensor(self.model, self.data, description, self.clock, self._body)
        if isinstance(description, CameraDescription):
            return self._cameras.open(description, self.clock, self._body)
        display: DisplayDescription = description  # the type checker reports a new kind of device here
        return MemoryDisplay(display.name)

    def close(self) -> None:
        """Release OpenGL and close the window. Further calls do nothing."""
        self._closing.close()

    def _open_window(self, width_m: float) -> None:
        window = Window(self.model, self.data, width_m)
        self._closing.callback(window.close)
        self._physics.step_listeners.append(window.show)

"""The MuJoCo backend: opens robots in a MuJoCo simulation in this process, and exports them as MJCF."""

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
    """The options of the backend. There are none."""


class MujocoBackend(Backend):
    """Opens each robot in its own simulation. Equal runs on one platform give results that are equal to the bit."""

    name = "mujoco"
    summary = "MuJoCo rigid-body physics, in process: on Python 3.10 to 3.13, 64-bit ARM too"
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
        """Raise BackendMissingError if the library is missing or too old, or cannot be imported.

        During its import, MuJoCo sets up the OpenGL library that the environment variable MUJOCO_GL selects. This can
        raise errors of any class. Each becomes a BackendMissingError.
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
                f'MuJoCo {mujoco.__version__} is too old, {needed} is needed. pip install --upgrade "mujoco>={needed}"',
                kind="library-too-old",
            )

    def open(self, setup: Setup) -> Robot:
        setup = setup.without_batteries()
        if setup.world is None:
            raise UsageError("the mujoco backend needs a world; name one with --world", kind="world-missing")
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
    """A robot in its world, and the clock that steps both."""

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
        """Open a device. Raises DeviceError for a motor or an encoder without a wheel."""
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
        """Release OpenGL and the window. It may be called again."""
        self._closing.close()

    def _open_window(self, width_m: float) -> None:
        window = Window(self.model, self.data, width_m)
        self._closing.callback(window.close)
        self._physics.step_listeners.append(window.show)

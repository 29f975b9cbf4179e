"""A MuJoCo simulation of one robot in one world, and the robot's true state."""

from __future__ import annotations

from contextlib import ExitStack
from functools import cached_property, partial

import numpy as np

from drivers.mujoco.body import Body
from drivers.mujoco.devices import MujocoMotor, Steering, cast_rays
from drivers.mujoco.model import build, compile_model
from drivers.mujoco.opengl import is_opengl_requested
from drivers.mujoco.rendering import Renderer, build_renderer
from drivers.mujoco.window import Window
from robotcore.description import AckermannDrive, DeviceDescription, WorldDescription
from robotcore.description.urdf import BASE
from robotcore.errors import BackendError
from robotcore.geometry import Pose, Twist
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.kind import simulate_device
from robotcore.hal.simulation_state import Array, SimulationState
from robotcore.hal.truth import RELEASE_M
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.encoder import EncoderDescription, SimulatedEncoder
from robotcore.kinds.motor import MotorDescription
from robotcore.simulation.body_cameras import CameraSet, needs_sheet
from robotcore.simulation.rigid_body import ContactCounter


class Simulation:
    """A MuJoCo simulation of one robot in one world, and its devices. It is the `TruthSource` of the run.

    The steps of ``clock`` are physics steps of MuJoCo. Each has two halves: `mj_step1` computes the contacts of the
    current positions, and `mj_step2` computes the next positions. After both, the contacts would be one step older than
    the positions. So this class calls `mj_step2` and then `mj_step1`, and all of ``data`` belongs to the same time.
    """

    def __init__(self, setup: Setup, world: WorldDescription, camera: str | None = None) -> None:
        """Build the model. No device is open.

        camera: `CameraOptions.camera`.
        """
        from mujoco import MjData, mj_step1, mj_step2, mjtGeom

        self._robot, self._world, self._seed = setup.robot, world, setup.seed
        self.clock = SteppedClock(setup.rate_hz, self._advance)
        self.model = compile_model(build(setup.robot, world, self.clock.step, has_sheet=needs_sheet(setup, camera)))
        self.data = MjData(self.model)
        self._finish_step, self._begin_step = mj_step2, mj_step1
        self._begin_step(self.model, self.data)
        self._body = Body(self.model, self.data, setup.robot)
        self._box = int(self.model.body(BASE).geomadr[0])
        self._ignored = {self._box, *np.flatnonzero(self.model.geom_type == mjtGeom.mjGEOM_PLANE).tolist()}
        self._contacts = ContactCounter()
        self._steering = self._open_steering()
        choice = camera or ("rendered" if is_opengl_requested() else None)
        self.cameras = CameraSet(choice, self.simulation_state)
        self._closing = ExitStack()
        self._closing.callback(self.cameras.close)
        self._window: Window | None = None
        if setup.gui:
            self._window = Window(self.model, self.data, max(world.floor.length_m, world.floor.width_m))
            self._closing.callback(self._window.close)

    def open(self, description: DeviceDescription) -> Device:
        """Open a device of the robot. Raises DeviceError for an encoder that is on no wheel.

        A motor that is on no wheel accepts commands without an effect.
        """
        driven = self._robot.drive.motors if self._robot.drive else ()
        if isinstance(description, MotorDescription) and description.name in driven:
            return MujocoMotor(self.model, self.data, description, self._body)
        if isinstance(description, EncoderDescription):
            body, joints = self._body, self._body.find_joints(description.name)
            return SimulatedEncoder(description, self.clock, lambda: body.angle(joints))
        if isinstance(description, CameraDescription):
            build_other = partial(build_renderer, self._world)
            return self.cameras.open(description, self._body.transform, lambda: self._renderer, build_other)
        return simulate_device(description, self.simulation_state)

    def close(self) -> None:
        """Release OpenGL and close the window. Further calls do nothing."""
        self._closing.close()

    def pose(self) -> Pose:
        self._require_sound()
        return self._body.pose()

    def twist(self) -> Twist:
        self._require_sound()
        return self._body.twist()

    def contacts(self) -> int:
        self._require_sound()
        return self._contacts.count

    @cached_property
    def simulation_state(self) -> SimulationState:
        """The state from which kinds of devices are simulated."""
        return SimulationState(
            self._robot,
            self._world,
            self.clock,
            self.pose,
            self.twist,
            self._cast,
            self._list_touched,
            self._seed,
            self._measure_wheel_angles,
        )

    def _measure_wheel_angles(self) -> dict[str, float]:
        motors = self._robot.drive.motors if self._robot.drive else ()
        return {motor: self._body.angle(self._body.find_joints(motor)) for motor in motors}

    @cached_property
    def _renderer(self) -> Renderer:
        """The renderer of all cameras. The first camera opens it, so a robot without cameras does not need OpenGL."""
        renderer = Renderer(self.model, self.data, self._world)
        self._closing.callback(renderer.close)
        return renderer

    def _open_steering(self) -> Steering | None:
        if not isinstance(drive := self._robot.drive, AckermannDrive):
            return None
        return Steering(self.model, self.data, drive, self.simulation_state.joints[drive.steering])

    def _cast(self, origin: Array, directions: Array, reach_m: float) -> Array:
        rotation, start = self._body.transform()
        return cast_rays(self.model, self.data, start + rotation @ origin, directions @ rotation.T, reach_m)

    def _list_touched(self) -> list[str]:
        return [self.model.geom(thing).name for thing in self._contacts.touched]

    def _advance(self, steps: int) -> None:
        start, length = self.clock.now(), self.clock.step
        for step in range(1, steps + 1):
            if self._steering:
                self._steering.turn(start + step * length)
            self._finish_step(self.model, self.data)
            self._begin_step(self.model, self.data)
            self._count_contacts()
        self._require_sound()
        if self._window:
            self._window.show()

    def _count_contacts(self) -> None:
        """Count the contacts that began in the last physics step, except those with the floor."""
        pairs = self.data.contact.geom.tolist()
        touching = {thing for pair in pairs if self._box in pair for thing in pair} - self._ignored
        if touching or self._contacts.touched:
            self._contacts.update(touching, self._is_near)

    def _is_near(self, thing: int) -> bool:
        from mujoco import mj_geomDistance

        return bool(mj_geomDistance(self.model, self.data, self._box, thing, 2 * RELEASE_M, None) <= RELEASE_M)

    def _require_sound(self) -> None:
        """Raise BackendError, with MuJoCo's message, if MuJoCo has reset the simulation.

        If a velocity becomes too great, MuJoCo moves all bodies back to the start, and continues with a warning.
        """
        warning = self.data.warning
        if warning.number.any():
            from mujoco import mju_warningText

            kind = int(warning.number.argmax())
            text = mju_warningText(kind, int(warning.lastinfo[kind]))
            raise BackendError(
                f"mujoco: {text} Check the masses and torques in the robot's description", kind="state-lost"
            )

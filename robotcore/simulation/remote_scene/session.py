"""Open a robot in an existing scene, run the simulation, and stop it afterwards if it was stopped before."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from enum import Enum

from pydantic import Field

from robotcore.description import DeviceDescription, RobotDescription, StrictModel
from robotcore.errors import BackendError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.device import Device
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import ServerClock
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.display import MemoryDisplay
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.simulation.remote_scene.bindings import ObjectsByDevice, SceneBinding, find_all, read_bindings
from robotcore.simulation.remote_scene.devices import (
    SceneCamera,
    SceneDisplay,
    SceneEncoder,
    SceneMotor,
    SceneRangeSensor,
    SceneTruth,
    choose_intrinsics,
)
from robotcore.simulation.remote_scene.interface import Scene, State
from robotcore.simulation.remote_scene.scene_kinds import (
    CameraBinding,
    JointBinding,
    ObjectBinding,
    require_scene_devices,
)

MAX_VELOCITY_RAD_S = 30.0
"""The assumed maximum velocity of a wheel, in rad/s, if the robot's description has none."""

ANSWER_SHARE = 0.9
"""The default time limit of a call, as a share of the robot's ``safety.answer_s``."""

GUARDIAN_EXTRA_LEASE_S = 60.0
"""The time by which the guardian extends its lease in lockstep, in seconds."""


class SimulationControl(str, Enum):
    """Whether this program or the user starts and stops the simulation.

    This program stops only a simulation that it has started.
    """

    PROGRAM = "program"
    """This program starts the simulation if it is stopped, and stops it at the end."""
    USER = "user"
    """The user starts and stops the simulation."""


class SceneOptions(StrictModel):
    """The options that the backends of remote simulators have in common."""

    host: str = "127.0.0.1"
    port: int = Field(ge=1, le=65535)
    answer_s: float | None = Field(default=None, gt=0, le=3600)
    """Time limit of a call, in seconds; None stands for 0.9 of ``safety.answer_s``."""
    simulation: SimulationControl = SimulationControl.PROGRAM
    """Whether this program or the user starts and stops the simulation of an existing scene."""

    def choose_answer_s(self, setup: Setup) -> float:
        """Return the time limit of a call, in seconds.

        By default a driver reports a late answer before the watchdog does. The driver's message has more details.
        """
        return self.answer_s or ANSWER_SHARE * setup.robot.safety.answer_s

    def list_cutoffs(self, cutoff: str, joints: Mapping[str, int], *, is_stepped: bool = True) -> Iterator[CutoffSpec]:
        """Yield the cutoff with which the guardian stops the wheels if this process cannot stop them.

        cutoff: the class of the cutoff, as ``module:Class``. Its parameters are ``host``, ``port`` and ``joints``.
        joints: the handle of the joint of each motor, by the name of the motor.
        is_stepped: whether the simulation waits for this program. If so, no wheel turns until the guardian acts.

        One cutoff stops all wheels, because a port may serve one connection at a time.
        """
        if joints:
            arguments = {"host": self.host, "port": self.port, "joints": list(joints.values())}
            yield CutoffSpec(" and ".join(joints), cutoff, arguments, GUARDIAN_EXTRA_LEASE_S if is_stepped else 0.0)


def _no_cutoffs(_joints: Mapping[str, int]) -> tuple[CutoffSpec, ...]:
    return ()  # a simulation in lockstep needs none, because its time stops if the program stops


def open_in_scene(
    setup: Setup,
    section: str,
    connect: Callable[[], Scene],
    control: SimulationControl = SimulationControl.PROGRAM,
    *,
    is_stepped: bool = True,
    cutoffs: Callable[[Mapping[str, int]], Iterable[CutoffSpec]] = _no_cutoffs,
) -> Robot:
    """Open a robot whose devices are objects of a scene.

    setup: the robot, the devices to open, and the rate of the loop.
    section: the section of the robot's file that binds devices to objects.
    connect: connects to the simulator. This function calls it after it has checked the section.
    control: whether this program or the user starts and stops the simulation.
    is_stepped: whether the clock advances the scene's time. If False, the clock follows the scene's time.
    cutoffs: returns the cutoffs with which the guardian stops the motors. Its argument maps the name of each motor to
        the handle of its joint.

    The motors stand still from the first step on. Raises DescriptionError if the section has a mistake, UsageError if
    the rate does not fit the time step, and the errors of `require_scene_devices`, `find_all` and `keep_running`. After
    an error, no connection is open.
    """
    require_scene_devices(setup)
    bound = read_bindings(setup.robot, section, setup.devices)
    with ExitStack() as undo:
        session = undo.enter_context(ExitStack())
        scene = connect()
        session.callback(scene.close)
        found = find_all(setup.robot.name, bound, scene)
        stepped = SteppedClock(setup.rate_hz, scene.advance, scene.read_time_step()) if is_stepped else None
        session.enter_context(keep_running(scene, control))
        for joint in _select_motor_joints(bound, found).values():
            scene.set_joint_velocity(joint, 0.0)  # the scene or an earlier program may have set a velocity
        if stepped:
            scene.advance(1)  # before the first step vision sensors have no picture
        clock = stepped or ServerClock(scene.read_time)
        undo.callback(clock.close)
        opener = _DeviceOpener(
            setup.robot, scene, clock, {each.description.name: each.settings for each in bound}, found, setup.seed
        )
        devices = []
        for description in setup.chosen_devices:
            devices.append(device := opener.open(description))
            undo.callback(device.close)
        truth = _create_truth(setup.robot, scene, found)
        specs = cutoffs(_select_motor_joints(bound, found))
        robot = Robot(setup.robot.name, clock, devices, truth=truth, release=session.close, cutoffs=specs)
        undo.pop_all()
    return robot


def _select_motor_joints(bound: Iterable[SceneBinding], found: ObjectsByDevice) -> dict[str, int]:
    motors = (each.description.name for each in bound if isinstance(each.description, MotorDescription))
    return {name: joint.handle for name in motors if (joint := found[name])}


@dataclass(frozen=True)
class _DeviceOpener:
    robot: RobotDescription
    scene: Scene
    clock: Clock
    bindings: Mapping[str, ObjectBinding]
    found: ObjectsByDevice
    seed: int

    def open(self, description: DeviceDescription) -> Device:
        bound_object = self.found.get(description.name)
        if bound_object is None:
            return MemoryDisplay(description.name)
        if isinstance(description, MotorDescription):
            return SceneMotor(description, self.scene, bound_object.handle, is_reversed=self._is_reversed(description))
        if isinstance(description, EncoderDescription):
            return self._open_encoder(description, bound_object.handle)
        if isinstance(description, RangeSensorDescription):
            return SceneRangeSensor(description, self.scene, bound_object.handle, self.clock, self.seed)
        if isinstance(description, CameraDescription):
            return self._open_camera(description, bound_object.handle)
        return SceneDisplay(description.name, self.scene, bound_object.handle)

    def _open_encoder(self, description: EncoderDescription, joint: int) -> SceneEncoder:
        limits = [motor.max_velocity_rad_s for motor in self.robot.all_of(MotorDescription)]
        quarter_turn_s = math.pi / 2 / max(limits, default=MAX_VELOCITY_RAD_S)
        is_reversed = self._is_reversed(description)
        return SceneEncoder(description, self.scene, joint, self.clock, quarter_turn_s, is_reversed=is_reversed)

    def _open_camera(self, description: CameraDescription, sensor: int) -> SceneCamera:
        binding = self.bindings[description.name]
        as_found = isinstance(binding, CameraBinding) and binding.as_found
        intrinsics = choose_intrinsics(description, self.scene.read_optics(sensor), as_found=as_found)
        return SceneCamera(description, self.scene, sensor, self.clock, self.seed, intrinsics)

    def _is_reversed(self, description: DeviceDescription) -> bool:
        binding = self.bindings[description.name]
        return isinstance(binding, JointBinding) and binding.reversed


def _create_truth(robot: RobotDescription, scene: Scene, found: ObjectsByDevice) -> SceneTruth | None:
    if (drive := robot.require_two_wheels("a scene")) is None:
        return None
    left, right = found.get(drive.left), found.get(drive.right)
    return SceneTruth(scene, left.handle, right.handle) if left and right else None


@contextmanager
def keep_running(scene: Scene, control: SimulationControl) -> Iterator[None]:
    """Return a context manager that runs the simulation. At the end it stops a simulation that it has started.

    Raises BackendError if the simulation is paused. With `SimulationControl.USER`, it also raises BackendError if the
    simulation is stopped.
    """
    state = scene.read_state()
    if state is State.PAUSED:
        raise BackendError(
            "the simulation is paused. Resume or stop it in the simulator, and run again", kind="simulation-paused"
        )
    if state is State.STOPPED and control is SimulationControl.USER:
        raise BackendError(
            "the simulation is stopped, and option simulation=user does not start it. "
            "Start it in the simulator, or omit the option",
            kind="simulation-stopped",
        )
    try:
        scene.start()
        yield
    finally:
        if state is State.STOPPED:
            scene.stop()

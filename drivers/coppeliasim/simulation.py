"""Build a robot and a world in a scene, simulate them, and remove them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from drivers.coppeliasim.builder import FORWARD, Placement, SceneBuilder, place_mount, place_on_floor
from drivers.coppeliasim.connection import LOADING_S
from drivers.coppeliasim.models import BuiltEncoder, BuiltMotor, BuiltRobot, BuiltWorld, build_robot, build_world
from drivers.coppeliasim.restore import (
    Undo,
    build_collections_undo,
    finish_building,
    release,
    require_empty,
    restore,
    save_scene_state,
)
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.sensors import (
    FanRangeSensor,
    ProximityRangeSensor,
    VisionSensorSpec,
    add_fan,
    add_proximity_sensor,
    add_vision_sensor,
    proximity_works,
    require_depth,
)
from drivers.coppeliasim.truth import ContactCounter, CoppeliaSimTruth
from robotcore.description import (
    AnyDevice,
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    SimulatedDevice,
    WorldDescription,
)
from robotcore.errors import BackendError, DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device
from robotcore.simulation.remote_scene import State
from robotcore.simulation.remote_scene.devices import SceneCamera, SceneDisplay


class Simulation:
    """The simulation of a built scene: its clock, its devices and its ground truth."""

    def __init__(self, scene: CoppeliaSimScene, setup: Setup, built: BuiltScene) -> None:
        self._scene, self._built = scene, built
        self._chosen = setup.chosen_devices
        self._motors: list[BuiltMotor] = []
        body = built.robot.body
        self._contacts = ContactCounter(scene.connection, body, built.world.things)
        self.clock = SteppedClock(setup.rate_hz, self._advance, scene.read_time_step())
        self.truth = CoppeliaSimTruth(scene.connection, body, built.robot.frame, self._contacts)

    def start(self) -> None:
        """Start the simulation in lockstep, and simulate one time step, in which all objects settle on the floor."""
        self._scene.start()
        self._scene.advance(1)

    def open(self, description: SimulatedDevice) -> Device:
        """Open one device. Raises DeviceError for a motor or an encoder without a wheel."""
        scene, clock = self._scene, self.clock
        if isinstance(description, MotorDescription):
            motor = BuiltMotor(scene, description, self._find_joint(description.name), clock.step)
            self._motors.append(motor)
            return motor
        if isinstance(description, EncoderDescription):
            return BuiltEncoder(scene, description, self._find_joint(description.name), clock)
        sensor = self._built.sensors[description.name]
        if isinstance(description, RangeSensorDescription):
            if self._built.has_proximity:
                return ProximityRangeSensor(scene, description, sensor, clock)
            return FanRangeSensor(scene.connection, description, sensor, clock)
        if isinstance(description, CameraDescription):
            return SceneCamera(description.name, description.intrinsics, scene, sensor, clock)
        display: DisplayDescription = description  # the type checker reports a new kind of device here
        return SceneDisplay(display.name, scene, sensor)

    @property
    def motor_joints(self) -> Mapping[str, int]:
        """The handles of the joints of the open motors, by motor name."""
        return {motor.name: self._find_joint(motor.name) for motor in self._motors}

    @property
    def notes(self) -> Sequence[str]:
        """One note for each range sensor, which names the means by which it measures."""
        means = "a proximity sensor" if self._built.has_proximity else "depth pictures; there are no proximity sensors"
        names = [description.name for description in self._chosen if isinstance(description, RangeSensorDescription)]
        return [f"{name} measures by {means}" for name in names]

    def _advance(self, steps: int) -> None:
        self._scene.connection.run_batch(partial(self._step, steps))

    def _step(self, steps: int) -> None:
        for _ in range(steps):
            for motor in self._motors:
                motor.drive()
            self._scene.advance(1)
            self._contacts.update()

    def _find_joint(self, name: str) -> int:
        if name not in self._built.robot.joints:
            raise DeviceError(name, "is not part of a wheel. Name it in the robot's [drive]", kind="no-wheel")
        return self._built.robot.joints[name]


SCREEN = (320, 240)
_SCREEN_FOV_RAD, _SCREEN_HEIGHT_M = 1.0, 3.0
_TOLERANCE = 1e-6


class BuiltScene(NamedTuple):
    """The handles of a built scene."""

    world: BuiltWorld
    robot: BuiltRobot
    sensors: Mapping[str, int]
    """The handles of the sensors, by device name."""
    has_proximity: bool
    """Whether range sensors use proximity sensors. Otherwise they use depth pictures."""


def clear_scene(scene: CoppeliaSimScene, builder: SceneBuilder) -> None:
    """Remove the objects that a killed program left in the scene.

    Raises BackendError if a simulation runs, or if the scene has the user's objects.
    """
    if (state := scene.read_state()) is not State.STOPPED:
        raise BackendError(
            f"coppeliasim: a simulation that this program did not start is {state.value} in the CoppeliaSim at "
            f"{scene.connection.address}. Stop it, and run again",
            kind="simulation-in-use",
            address=str(scene.connection.address),
            state=state.value,
        )
    restore(builder)
    require_empty(builder)


def leave_scene(scene: CoppeliaSimScene, builder: SceneBuilder, *, keep: bool) -> None:
    """Stop the simulation. Then restore the user's scene, or leave the built scene to other programs.

    keep: whether to leave the built scene.

    If the simulator has ended or hangs, the function does nothing. The next program restores the scene.
    """
    if scene.connection.is_lost:
        return
    scene.stop()
    if keep:
        release(builder)
    else:
        restore(builder)


def build_scene(scene: CoppeliaSimScene, builder: SceneBuilder, setup: Setup, world: WorldDescription) -> BuiltScene:
    """Build the world and the robot in an empty scene, and set the time step to the period of a tick."""
    built_world = build_world(builder, world)
    has_proximity = proximity_works(builder, scene.detect)
    if not has_proximity and any(
        isinstance(description, RangeSensorDescription) for description in setup.chosen_devices
    ):
        require_depth(builder, scene.connection)
    undo: list[Undo] = [_build_engine_undo(builder), _build_time_step_undo(scene, builder)]
    undo += build_collections_undo(built_world.root, (built_world.visible, built_world.detectable))
    save_scene_state(builder, built_world.root, world.light, undo)
    _set_engine(builder)
    _set_time_step(scene, builder, 1 / setup.rate_hz)
    robot = build_robot(builder, setup.robot, world.start.pose)
    sensors = _Sensors(
        builder, robot.body, place_on_floor(world.start.pose), built_world, compute_sky_grey(world), has_proximity
    )
    handles = {
        description.name: handle
        for description in setup.chosen_devices
        if (handle := sensors.add(description)) is not None
    }
    finish_building(builder, built_world.root)
    return BuiltScene(built_world, robot, handles, has_proximity)


def compute_sky_grey(world: WorldDescription) -> float:
    """Return the grey nearest to the colour of the sky, from 0 to 1."""
    return sum(world.light.sky_colour) / 3 / 255


class _Sensors(NamedTuple):
    """Adds sensors to the body of a robot."""

    builder: SceneBuilder
    body: int
    frame: Placement
    world: BuiltWorld
    sky_grey: float
    has_proximity: bool

    def add(self, description: AnyDevice) -> int | None:
        """Create the sensor of a device, and return its handle; None for a device without a sensor."""
        if isinstance(description, RangeSensorDescription):
            add = add_proximity_sensor if self.has_proximity else add_fan
            return add(self.builder, description, self.body, self.frame, self.world.detectable)
        if isinstance(description, CameraDescription):
            size, fov = (description.width_px, description.height_px), description.horizontal_fov_rad
            spec = VisionSensorSpec(size, fov, background=self.sky_grey, visible=self.world.visible, ignored="depth")
            return add_vision_sensor(
                self.builder, spec, description.name, self.frame.compose(place_mount(description.mount)), self.body
            )
        if isinstance(description, DisplayDescription):
            place = self.frame.compose(FORWARD._replace(z=_SCREEN_HEIGHT_M))
            return add_vision_sensor(
                self.builder, VisionSensorSpec(SCREEN, _SCREEN_FOV_RAD), description.name, place, self.body
            )
        return None


def _build_engine_undo(builder: SceneBuilder) -> Undo:
    """Return the call that selects the present physics engine again."""
    parameter = builder.constant("intparam_dynamic_engine")
    return "setInt32Param", parameter, builder.call("getInt32Param", parameter)


def _set_engine(builder: SceneBuilder) -> None:
    """Select the physics engine Bullet. With other engines, the built wheels slip or do not turn."""
    builder.call("setInt32Param", builder.constant("intparam_dynamic_engine"), builder.constant("physics_bullet"))


def _build_time_step_undo(scene: CoppeliaSimScene, builder: SceneBuilder) -> Undo:
    """Return the call that sets the present time step again."""
    return "setFloatParam", builder.constant("floatparam_simulation_time_step"), scene.read_time_step()


def _set_time_step(scene: CoppeliaSimScene, builder: SceneBuilder, step_s: float) -> None:
    """Set the time step; raises BackendError if the simulator does not accept it."""
    parameter = builder.constant("floatparam_simulation_time_step")
    scene.connection.sim("setFloatParam", parameter, step_s, within_s=LOADING_S)
    if abs((got := scene.read_time_step()) - step_s) > _TOLERANCE * step_s:
        raise BackendError(
            f"coppeliasim: the simulation's time step was set to {step_s:g} s and is {got:g} s. "
            "Open a new scene in CoppeliaSim, or choose another --rate",
            kind="time-step-refused",
            requested_s=step_s,
            actual_s=got,
        )

"""Build a robot and a world in a scene, simulate them, and remove them afterwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from drivers.coppeliasim.address import build_error
from drivers.coppeliasim.builder import FORWARD, SceneBuilder, place_mount, place_on_floor
from drivers.coppeliasim.models import BuiltEncoder, BuiltMotor, BuiltRobot, BuiltWorld, build_robot, build_world
from drivers.coppeliasim.restore import (
    UndoCall,
    build_collections_undo,
    enable_sensor_updates,
    finish_building,
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
    do_proximity_sensors_work,
    require_depth,
)
from drivers.coppeliasim.truth import ContactCounter, CoppeliaSimTruth
from robotcore.description import DeviceDescription, WorldDescription
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.display import DisplayDescription
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.lens import Lens
from robotcore.simulation.remote_scene import State
from robotcore.simulation.remote_scene.devices import SceneCamera, SceneDisplay


class Simulation:
    """The simulation of a built scene: its clock, its devices and its ground truth."""

    def __init__(self, scene: CoppeliaSimScene, setup: Setup, built: BuiltScene) -> None:
        self._scene, self._built = scene, built
        self._chosen = setup.chosen_devices
        self._motors: list[BuiltMotor] = []
        body = built.robot.body
        self._seed = setup.seed
        self._contacts = ContactCounter(scene.connection, body, built.world.things)
        self.clock = SteppedClock(setup.rate_hz, self._advance, scene.read_time_step())
        self.truth = CoppeliaSimTruth(scene.connection, body, built.robot.frame, self._contacts)

    def start(self) -> None:
        """Start the simulation in lockstep, and simulate one time step so that the robot settles on the floor."""
        self._scene.start()
        self._scene.advance(1)

    def open(self, description: DeviceDescription) -> Device:
        """Open one device. Raises DeviceError for a motor or an encoder that belongs to no wheel."""
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
                return ProximityRangeSensor(scene, description, sensor, clock, self._seed)
            return FanRangeSensor(scene.connection, description, sensor, clock, self._seed)
        if isinstance(description, CameraDescription):
            return SceneCamera(description, scene, sensor, clock, self._seed)
        return SceneDisplay(description.name, scene, sensor)

    @property
    def motor_joints(self) -> Mapping[str, int]:
        """The handle of the joint of each open motor, by the motor's name."""
        return {motor.name: self._find_joint(motor.name) for motor in self._motors}

    @property
    def notes(self) -> Sequence[str]:
        """A note for each range sensor: whether it uses a proximity sensor or depth pictures."""
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
            raise DeviceError(
                name, "it belongs to no wheel. Name it in the section [drive] of the robot's file", kind="no-wheel"
            )
        return self._built.robot.joints[name]


SCREEN = (320, 240)
_SCREEN_FOV_RAD, _SCREEN_HEIGHT_M = 1.0, 3.0
_TOLERANCE = 1e-6

PHYSICS_STEP_S = 0.005
"""The time step of the physics engine in a built scene, in seconds. The wheels were tuned with it."""


class BuiltScene(NamedTuple):
    """The handles of the objects of a built scene."""

    world: BuiltWorld
    robot: BuiltRobot
    sensors: Mapping[str, int]
    """The handle of the vision sensor or proximity sensor of each device, by the device's name."""
    has_proximity: bool
    """Whether range sensors use proximity sensors. Otherwise they use depth pictures."""


def clear_scene(scene: CoppeliaSimScene, builder: SceneBuilder) -> None:
    """Remove the objects that a killed program has left in the scene.

    Raises BackendError if a simulation runs, or if the user has objects in the scene.
    """
    if (state := scene.read_state()) is not State.STOPPED:
        raise build_error(
            scene.connection.address,
            "simulation-in-use",
            f"a simulation that this program did not start is {state.value} in the CoppeliaSim at "
            f"{scene.connection.address}. Stop the simulation, and run again",
            state=state.value,
        )
    restore(builder)
    require_empty(builder)


def leave_scene(scene: CoppeliaSimScene, builder: SceneBuilder, *, keep: bool) -> None:
    """Stop the simulation. Then restore the user's scene, or keep the built one.

    keep: whether to keep the built robot and world.

    If the simulator has ended or hangs, this function does nothing. The next program then restores the scene.
    """
    if scene.connection.is_lost:
        return
    scene.stop()
    if keep:
        enable_sensor_updates(builder)
    else:
        restore(builder)


def build_scene(scene: CoppeliaSimScene, builder: SceneBuilder, setup: Setup, world: WorldDescription) -> BuiltScene:
    """Build the world and the robot in an empty scene, and set the simulation's time step to one tick of the loop."""
    built_world = build_world(builder, world)
    has_proximity = do_proximity_sensors_work(builder, scene.detect)
    if not has_proximity and any(
        isinstance(description, RangeSensorDescription) for description in setup.chosen_devices
    ):
        require_depth(builder, scene.connection)
    undo = _build_physics_undo(builder)
    undo += build_collections_undo(built_world.root, (built_world.visible, built_world.detectable))
    save_scene_state(builder, built_world.root, world.light, undo)
    _set_physics(scene, builder, 1 / setup.rate_hz)
    robot = build_robot(builder, setup.robot, world.start.pose)
    sensors = {
        description.name: sensor
        for description in setup.chosen_devices
        if (sensor := _add_sensor(builder, description, world, built_world, robot.body, has_proximity)) is not None
    }
    finish_building(builder, built_world.root)
    return BuiltScene(built_world, robot, sensors, has_proximity)


def compute_sky_grey(world: WorldDescription) -> float:
    """Return the mean of the sky's red, green and blue, from 0 to 1."""
    return sum(world.light.sky_colour) / 3 / 255


def _add_sensor(
    builder: SceneBuilder,
    description: DeviceDescription,
    world: WorldDescription,
    built_world: BuiltWorld,
    body: int,
    has_proximity: bool,  # noqa: FBT001
) -> int | None:
    """Create the sensor of a device, and return its handle. A motor or an encoder has none."""
    frame = place_on_floor(world.start.pose)
    if isinstance(description, RangeSensorDescription):
        add = add_proximity_sensor if has_proximity else add_fan
        return add(builder, description, body, frame, built_world.detectable)
    if isinstance(description, CameraDescription):
        pinhole, sky = Lens(description.intrinsics).pinhole, compute_sky_grey(world)
        spec = VisionSensorSpec(
            (pinhole.width, pinhole.height),
            pinhole.horizontal_fov,
            background=sky,
            visible=built_world.visible,
            ignored="depth",
        )
        return add_vision_sensor(builder, spec, description.name, frame.compose(place_mount(description.mount)), body)
    if isinstance(description, DisplayDescription):
        spec, place = VisionSensorSpec(SCREEN, _SCREEN_FOV_RAD), frame.compose(FORWARD._replace(z=_SCREEN_HEIGHT_M))
        return add_vision_sensor(builder, spec, description.name, place, body)
    return None


def _set_physics(scene: CoppeliaSimScene, builder: SceneBuilder, step_s: float) -> None:
    """Select the physics engine Bullet, and set the time steps of the simulation and of the physics.

    step_s: the time step of the simulation, in seconds.

    With other engines, the built wheels slip or do not turn.
    """
    constant = builder.constant
    builder.call("setInt32Param", constant("intparam_dynamic_engine"), constant("physics_bullet"))
    builder.call("setFloatParam", constant("floatparam_physicstimestep"), PHYSICS_STEP_S)
    builder.call("setFloatParam", constant("floatparam_simulation_time_step"), step_s)
    if abs((got := scene.read_time_step()) - step_s) > _TOLERANCE * step_s:
        raise build_error(
            scene.connection.address,
            "time-step-refused",
            f"the simulation's time step was set to {step_s:g} s and is {got:g} s. Open a new scene in CoppeliaSim, or "
            "choose another --rate",
            requested_s=step_s,
            actual_s=got,
        )


def _build_physics_undo(builder: SceneBuilder) -> list[UndoCall]:
    """Return the calls that restore what `_set_physics` changes."""
    parameters = [
        ("Int32Param", builder.constant("intparam_dynamic_engine")),
        ("FloatParam", builder.constant("floatparam_physicstimestep")),
        ("FloatParam", builder.constant("floatparam_simulation_time_step")),
    ]
    return [(f"set{kind}", number, builder.call(f"get{kind}", number)) for kind, number in parameters]

"""Build a world and a robot as objects of a scene, and the robot's motors and encoders.

The world has a floor, prisms and balls, which do not move. The robot has a body, wheels on joints, and casters.

Three choices make the robot follow its commands in the physics engine Bullet:

- The collision shape of a wheel is a ball. It touches the floor at one point, so that the track width is exact.
- The centre of mass is over the axle, with a caster in front and one behind. If one caster carried the mass, the robot
  would creep while its wheels stand still.
- A caster has no friction. A force sensor connects it to the body, because no connection in Bullet is stiffer.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from drivers.coppeliasim.builder import AXLE, NO_UNDO, CollisionMask, Placement, SceneBuilder, place_on_floor
from drivers.coppeliasim.restore import begin_building
from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.description import Ball, Box, Caster, Cylinder, Drive, RobotDescription, TwoWheelDrive, WorldDescription
from robotcore.description.robot import Body
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.hal.sampling import SampleCache
from robotcore.kinds.encoder import Angle, Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription

GROUND_M, GROUND_DEPTH_M = 60.0, 0.1
"""The side length and the thickness of the ground, in metres.

The ground is larger than the world's floor, so that the vision sensors see it up to the end of their range.
"""


class BuiltWorld(NamedTuple):
    """The handles of a world's objects."""

    root: int
    things: frozenset[int]
    """The handles of the prisms and balls. The ground truth counts the robot's contacts with them."""
    visible: int
    """The handle of the collection of the objects that cameras see. It contains all objects of the world."""
    detectable: int
    """The handle of the collection of the objects that range sensors detect. It contains all except the floor."""


def build_world(builder: SceneBuilder, world: WorldDescription) -> BuiltWorld:
    """Create the objects of a world. After the caller has built the robot too, it must call `finish_building`."""
    root = builder.create_dummy(world.name)
    builder.write_note(root, NO_UNDO)
    begin_building(builder, root)
    floor = _add_floor(builder, world, root)
    builder.set_friction(floor, 1.0)
    prisms = [_add_prism(builder, prism, root) for prism in world.prisms]
    balls = [_add_ball(builder, ball, root) for ball in world.targets]
    visible, detectable = builder.create_collection(root), builder.create_collection(root, without=floor)
    return BuiltWorld(root, frozenset((*prisms, *balls)), visible, detectable)


def _add_floor(builder: SceneBuilder, world: WorldDescription, root: int) -> int:
    size = (GROUND_M, GROUND_M, GROUND_DEPTH_M)
    place = Placement(0.0, 0.0, -GROUND_DEPTH_M / 2)
    return builder.create_shape("cuboid", size, place, world.floor.colour, CollisionMask.FLOOR, "floor", root)


def _add_prism(builder: SceneBuilder, prism: Box | Cylinder, root: int) -> int:
    place = place_on_floor(Pose(prism.x_m, prism.y_m, prism.yaw_rad))._replace(z=prism.height_m / 2)
    if isinstance(prism, Box):
        kind, across = "cuboid", (prism.length_m, prism.width_m)
    else:
        kind, across = "cylinder", (2 * prism.radius_m, 2 * prism.radius_m)
    return builder.create_shape(
        kind, (*across, prism.height_m), place, prism.colour, CollisionMask.THING, prism.name, root
    )


def _add_ball(builder: SceneBuilder, ball: Ball, root: int) -> int:
    size = (2 * ball.radius_m,) * 3
    place = Placement(ball.x_m, ball.y_m, ball.radius_m)
    return builder.create_shape("spheroid", size, place, ball.colour, CollisionMask.THING, ball.name, root)


WHEEL_FORCE_NM = 2.0
TURNS_RAD = 1e5
CASTER_MASS_KG = 0.02
DARK = (30, 30, 30)


class BuiltRobot(NamedTuple):
    """The handles of a robot's objects, and the robot's frame."""

    body: int
    """The handle of the robot's body, which is the parent of its other objects."""
    joints: Mapping[str, int]
    """The handle of the joint of each motor and of each encoder, by the device's name."""
    frame: Placement
    """The robot's frame relative to the frame of the body."""


def build_robot(builder: SceneBuilder, robot: RobotDescription, start: Pose) -> BuiltRobot:
    """Create a robot at its start pose. The physics engine does not move a robot without a drive."""
    body, frame = robot.body, place_on_floor(start)
    centre = Placement(*body.middle_m)
    size = (body.length_m, body.width_m, body.height_m)
    root = builder.create_shape("cuboid", size, frame.compose(centre), body.colour, CollisionMask.BODY, robot.name)
    builder.write_note(root, NO_UNDO)
    joints: dict[str, int] = {}
    if drive := robot.require_two_wheels("CoppeliaSim"):
        builder.make_dynamic(root, body.mass_kg, body.moments_kg_m2, -body.centre_x_m)
        joints = _add_wheels(builder, drive, root, frame)
        if drive.caster:
            _add_casters(builder, drive.caster, root, frame, _compute_distance_to_nearer_end(body))
    return BuiltRobot(root, joints, Placement(-centre.x, 0.0, -centre.z))


def _add_wheels(builder: SceneBuilder, drive: TwoWheelDrive, root: int, frame: Placement) -> dict[str, int]:
    joints: dict[str, int] = {}
    for wheel in drive.wheels:
        hub = frame.compose(AXLE._replace(y=wheel.y_m, z=drive.wheel_radius_m))
        joint = _add_joint(builder, wheel.name, root, hub)
        _add_wheel(builder, drive, joint, hub)
        joints |= {name: joint for name in (wheel.motor, wheel.encoder) if name}
    return joints


def _add_joint(builder: SceneBuilder, motor: str, root: int, hub: Placement) -> int:
    constant = builder.constant
    joint = builder.make("createJoint", constant("joint_revolute"), constant("jointmode_dynamic"), 0, [0.04, 0.01])
    builder.call("setJointInterval", joint, False, [-TURNS_RAD, 2 * TURNS_RAD])  # otherwise its angle wraps at π
    builder.set_int(joint, "jointintparam_dynctrlmode", constant("jointdynctrl_velocity"))
    builder.call("setJointTargetForce", joint, WHEEL_FORCE_NM)
    builder.call("setJointTargetVelocity", joint, 0.0)  # the API creates joints that turn
    builder.put(joint, hub, motor, root)
    return joint


def _add_wheel(builder: SceneBuilder, drive: Drive, joint: int, hub: Placement) -> None:
    size = (2 * drive.wheel_radius_m,) * 3
    wheel = builder.create_shape("spheroid", size, hub, DARK, CollisionMask.WHEEL, "wheel", joint)
    builder.make_dynamic(wheel, drive.wheel_mass_kg, _compute_ball_moments(drive.wheel_mass_kg, drive.wheel_radius_m))
    builder.set_friction(wheel, 1.0)


def _add_casters(builder: SceneBuilder, caster: Caster, root: int, frame: Placement, room: float) -> None:
    away = min(abs(caster.x_m), room)
    for name, x in (("front_caster", away), ("rear_caster", -away)):
        place, size = frame.compose(Placement(x, 0.0, caster.radius_m)), (2 * caster.radius_m,) * 3
        sensor = builder.make("createForceSensor", 0, [0, 1, 1, 0, 0], [0.01, 100.0, 100.0, 0, 0])
        builder.put(sensor, place, name, root)
        ball = builder.create_shape("spheroid", size, place, DARK, CollisionMask.CASTER, "ball", sensor)
        builder.make_dynamic(ball, CASTER_MASS_KG, _compute_ball_moments(CASTER_MASS_KG, caster.radius_m))
        builder.set_friction(ball, 0.0)


def _compute_distance_to_nearer_end(body: Body) -> float:
    return min(body.front_x_m, body.length_m - body.front_x_m)


def _compute_ball_moments(mass: float, radius: float) -> tuple[float, float, float]:
    moment = 0.4 * mass * radius * radius
    return moment, moment, moment


class BuiltMotor(Motor):
    """A motor whose joint follows the commanded velocity with the lag of the robot's description.

    step: the time step of the simulation, in seconds.

    The joint has one velocity during a time step h, and h can be as long as the time constant τ of the lag. So the
    motor sends the mean velocity of a first-order lag over the step. This mean is v + (c - v)·(1 - τ/h·(1 - exp(-h/τ)))
    with the velocity v at the beginning of the step and the commanded velocity c.
    """

    def __init__(self, scene: CoppeliaSimScene, description: MotorDescription, joint: int, step: float) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._scene, self._joint = scene, joint
        lag = description.lag_s
        self._gain = -math.expm1(-step / lag) if lag else 1.0
        self._mean_gain = 1 - lag / step * self._gain
        self._respond = description.respond
        self._command = self._velocity = self._sent = 0.0

    def drive(self) -> None:
        """Send the mean velocity that the joint must have in the next time step. Call this before each time step."""
        missing = self._command - self._velocity
        self._send(self._velocity + missing * self._mean_gain)
        self._velocity += missing * self._gain

    def _apply(self, rad_s: float) -> None:
        self._command = float(self._respond(rad_s))  # the remote API encodes no NumPy types

    def _send(self, rad_s: float) -> None:
        if rad_s != self._sent:
            self._scene.set_joint_velocity(self._joint, rad_s)
            self._sent = rad_s


class BuiltEncoder(Encoder):
    """An encoder that measures the angle by which a wheel's joint has turned since the robot was opened."""

    def __init__(self, scene: CoppeliaSimScene, description: EncoderDescription, joint: int, clock: Clock) -> None:
        super().__init__(description.name)
        self._scene, self._description, self._joint = scene, description, joint
        self._zero = scene.read_joint_position(joint)
        self._newest_at = SampleCache(clock, self._count)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        angle = self._scene.read_joint_position(self._joint) - self._zero
        return Angle(self._description.quantise(angle), time, sequence)

"""A scene with a robot and a world from their descriptions. Each object has the name of its device."""

from __future__ import annotations

import math

from robotcore.description import (
    Ball,
    Box,
    CameraDescription,
    Cylinder,
    DisplayDescription,
    MotorDescription,
    Mount,
    RangeSensorDescription,
    RobotDescription,
    WorldDescription,
)
from robotcore.raycast import FAN_SETBACK_M
from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import Joint, Node, Primitive, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector, multiply
from tests.doubles.coppeliasim.scene.world import SceneLight
from tests.doubles.coppeliasim.scenes.parts import (
    AHEAD,
    create_ball,
    create_dynamic,
    create_floor,
    create_static,
    create_wheel_joint,
)

SCREEN_PX = (320, 240)
NEAR_M, FAR_M = 0.01, 40.0
BEYOND_M = 40.0
"""The width by which the ground continues beyond the world's floor, in metres."""


def described_scene(robot: RobotDescription, world: WorldDescription) -> Simulator:
    """Return a scene with ``/NAME`` as the robot's body, its devices below it, and the display as ``/screen``."""
    graph = Graph()
    _add_world(graph, world)
    _add_robot(graph, robot, world)
    return Simulator(graph, SceneLight(world.light))


def _add_world(graph: Graph, world: WorldDescription) -> None:
    beyond = 2 * BEYOND_M
    graph.add(create_floor(world.floor.length_m + beyond, world.floor.width_m + beyond, _rgb(world.floor.colour)))
    for prism in world.prisms:
        graph.add(_prism(prism))
    for target in world.targets:
        graph.add(_ball(target))


def _prism(prism: Box | Cylinder) -> Shape:
    at = Transform.rotated(prism.yaw_rad, (prism.x_m, prism.y_m, prism.height_m / 2))
    if isinstance(prism, Box):
        return create_static(prism.name, (prism.length_m, prism.width_m, prism.height_m), at, _rgb(prism.colour))
    across = 2 * prism.radius_m
    return create_static(prism.name, (across, across, prism.height_m), at, _rgb(prism.colour), Primitive.CYLINDER)


def _ball(target: Ball) -> Shape:
    return create_ball(target.name, target.radius_m, target.x_m, target.y_m, _rgb(target.colour))


def _add_robot(graph: Graph, robot: RobotDescription, world: WorldDescription) -> None:
    description, start = robot.body, world.start.pose
    frame = Transform.rotated(start.heading, (start.x, start.y, 0.0))
    middle = Transform((description.centre_x_m, 0.0, description.clearance_m + description.height_m / 2))
    size = (description.length_m, description.width_m, description.height_m)
    body = create_dynamic(
        robot.name, size, frame.compose(middle), Primitive.CUBOID, description.mass_kg, _rgb(description.colour)
    )
    body.is_model_base, body.is_static = True, robot.drive is None
    graph.add(body)
    inward = middle.inverse
    for motor in robot.all_of(MotorDescription):
        _add_wheel(graph, body, inward, robot, motor)
    for device in robot.devices:
        if sensor := _create_sensor(device, inward):
            graph.add(sensor, body)
        elif isinstance(device, DisplayDescription):
            graph.add(_screen(device.name))


def _add_wheel(graph: Graph, body: Node, inward: Transform, robot: RobotDescription, motor: MotorDescription) -> None:
    drive = robot.drive
    if drive is None or motor.name not in {drive.left, drive.right}:
        graph.add(Joint(motor.name), body)
        return
    radius, side = drive.wheel_radius_m, 1 if motor.name == drive.left else -1
    hub = inward.apply((0.0, side * drive.track_m / 2, radius))
    joint = graph.add(create_wheel_joint(motor.name, hub, motor.lag_s), body)
    size = (2 * radius, 2 * radius, drive.wheel_width_m)
    graph.add(create_dynamic(f"{motor.name}_wheel", size, Transform(), Primitive.CYLINDER, drive.wheel_mass_kg), joint)


def _create_sensor(description: object, inward: Transform) -> Node | None:
    if isinstance(description, RangeSensorDescription):
        nose = ProximitySensor(
            description.name, reach=description.max_range_m, cone=description.cone_rad, setback=FAN_SETBACK_M
        )
        nose.local = inward.compose(_looking(description.mount))
        return nose
    if isinstance(description, CameraDescription):
        eye = VisionSensor(
            description.name, width=description.width_px, height=description.height_px, near=NEAR_M, far=FAR_M
        )
        eye.angle = _longer(description)
        eye.local = inward.compose(_looking(description.mount))
        return eye
    return None


def _screen(name: str) -> VisionSensor:
    width, height = SCREEN_PX
    up_high = Transform((0.0, 0.0, 3.0))
    return VisionSensor(name, width=width, height=height, local=up_high, takes_external_pictures=True)


def _looking(mount: Mount) -> Transform:
    yaw, pitch = mount.yaw_rad, mount.pitch_rad
    turned: Quaternion = multiply(_about_z(yaw), (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)))
    return Transform((mount.x_m, mount.y_m, mount.z_m), multiply(turned, AHEAD))


def _about_z(angle: float) -> Quaternion:
    return (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))


def _longer(description: CameraDescription) -> float:
    stretch = max(1.0, description.height_px / description.width_px)
    return 2 * math.atan(math.tan(description.horizontal_fov_rad / 2) * stretch)


def _rgb(colour: tuple[int, int, int]) -> Vector:
    red, green, blue = colour
    return red / 255, green / 255, blue / 255

"""A scene with a robot and a world from their descriptions. Each object has the name of its device."""

from __future__ import annotations

import math

from robotcore.description import Box, Cylinder, DeviceDescription, Mount, RobotDescription, WorldDescription
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.display import DisplayDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.raycast import FAN_SETBACK_M
from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import Joint, Primitive, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform, Vector
from tests.doubles.coppeliasim.scenes.parts import AHEAD, HIGH, add_wheel, create_ball, create_floor

SCREEN_PX = (320, 240)
NEAR_M, FAR_M = 0.01, 40.0
BEYOND_M = 40.0
"""The width by which the ground continues beyond the world's floor, in metres."""


def described_scene(robot: RobotDescription, world: WorldDescription) -> Simulator:
    """Return a scene with ``/NAME`` as the robot's body, its devices below it, and the display as ``/screen``."""
    graph = Graph()
    beyond = 2 * BEYOND_M
    graph.add(create_floor(world.floor.length_m + beyond, world.floor.width_m + beyond, _to_rgb(world.floor.colour)))
    for prism in world.prisms:
        graph.add(_create_prism(prism))
    for target in world.targets:
        graph.add(create_ball(target.name, target.radius_m, target.x_m, target.y_m, _to_rgb(target.colour)))
    _add_robot(graph, robot, world)
    return Simulator(graph, world.light)


def _create_prism(prism: Box | Cylinder) -> Shape:
    shape = Shape(prism.name, colour=_to_rgb(prism.colour))
    shape.local = Transform.rotated(prism.yaw_rad, (prism.x_m, prism.y_m, prism.height_m / 2))
    if isinstance(prism, Box):
        shape.size = (prism.length_m, prism.width_m, prism.height_m)
    else:
        shape.primitive = Primitive.CYLINDER
        shape.size = (2 * prism.radius_m, 2 * prism.radius_m, prism.height_m)
    return shape


def _add_robot(graph: Graph, robot: RobotDescription, world: WorldDescription) -> None:
    start, size = world.start.pose, (robot.body.length_m, robot.body.width_m, robot.body.height_m)
    middle = Transform(robot.body.middle_m)
    body = Shape(robot.name, size=size, is_model_base=True, is_static=robot.drive is None)
    body.local = Transform.rotated(start.heading, (start.x, start.y, 0.0)).compose(middle)
    graph.add(body)
    for device in robot.devices:
        _add_device(graph, body, middle.inverse, robot, device)


def _add_device(
    graph: Graph, body: Shape, inward: Transform, robot: RobotDescription, device: DeviceDescription
) -> None:
    """Add the object of a device. ``inward`` is the robot's frame in the frame of the body."""
    if isinstance(device, MotorDescription):
        _add_motor(graph, body, inward, robot, device)
    elif isinstance(device, RangeSensorDescription):
        nose = ProximitySensor(device.name, reach=device.max_range_m, cone=device.cone_rad, setback=FAN_SETBACK_M)
        nose.local = inward.compose(_place_mount(device.mount))
        graph.add(nose, body)
    elif isinstance(device, CameraDescription):
        eye = VisionSensor(device.name, width=device.width_px, height=device.height_px, near=NEAR_M, far=FAR_M)
        stretch = max(1.0, device.height_px / device.width_px)
        eye.angle = 2 * math.atan(math.tan(device.horizontal_fov_rad / 2) * stretch)
        eye.local = inward.compose(_place_mount(device.mount))
        graph.add(eye, body)
    elif isinstance(device, DisplayDescription):
        width, height = SCREEN_PX
        graph.add(VisionSensor(device.name, width=width, height=height, local=HIGH, takes_external_pictures=True))


def _add_motor(graph: Graph, body: Shape, inward: Transform, robot: RobotDescription, motor: MotorDescription) -> None:
    drive = robot.drive
    if drive is None or motor.name not in {drive.left, drive.right}:
        graph.add(Joint(motor.name), body)
        return
    radius, side = drive.wheel_radius_m, 1 if motor.name == drive.left else -1
    hub = inward.apply((0.0, side * drive.track_m / 2, radius))
    add_wheel(graph, body, Joint(motor.name, lag=motor.lag_s), hub, radius, f"{motor.name}_wheel")


def _place_mount(mount: Mount) -> Transform:
    pitch = mount.pitch_rad / 2
    pitched = Transform(quaternion=(0.0, math.sin(pitch), 0.0, math.cos(pitch)))
    turned = Transform.rotated(mount.yaw_rad, (mount.x_m, mount.y_m, mount.z_m))
    return turned.compose(pitched).compose(Transform(quaternion=AHEAD))


def _to_rgb(colour: tuple[int, int, int]) -> Vector:
    red, green, blue = colour
    return red / 255, green / 255, blue / 255

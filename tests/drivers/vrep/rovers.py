"""The rover, described, as objects of a double's scene; what it is in is a described world."""

from __future__ import annotations

import math

from robotcore.description import (
    Ball,
    Box,
    CameraDescription,
    Cylinder,
    Drive,
    Mount,
    RangeSensorDescription,
    RobotDescription,
    WorldDescription,
)
from robotcore.geometry import Pose
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import (
    Joint,
    JointMode,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector
from tests.doubles.coppeliasim.scene.simulator import Simulator

TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
AHEAD: Quaternion = (0.5, 0.5, 0.5, 0.5)

Thing = Box | Cylinder | Ball


def scene_of(robot: RobotDescription, world: WorldDescription) -> Simulator:
    """Return a simulation that is stopped, with the robot at its start."""
    graph = Graph()
    size = (world.floor.length_m, world.floor.width_m, 0.1)
    floor = Shape("floor", size=size, colour=_rgb(world.floor.colour))
    graph.put(graph.add(floor), Transform((0.0, 0.0, -0.05)))
    _add_things(graph, world)
    _add_robot(graph, robot, world.start.pose)
    graph.add(VisionSensor("v1", width=64, height=48, takes_external_pictures=True))
    return Simulator(graph)


def _add_things(graph: Graph, world: WorldDescription) -> None:
    for thing in (*world.prisms, *world.targets):
        place = Transform((thing.x_m, thing.y_m, _size(thing)[2] / 2))
        if not isinstance(thing, Ball):
            place = Transform.turned(thing.yaw_rad, place.position)
        colour = _rgb(thing.colour)
        shape = Shape(thing.name, primitive=_primitive(thing), size=_size(thing), colour=colour)
        graph.put(graph.add(shape), place)


def _primitive(thing: Thing) -> Primitive:
    if isinstance(thing, Ball):
        return Primitive.SPHEROID
    return Primitive.CUBOID if isinstance(thing, Box) else Primitive.CYLINDER


def _size(thing: Thing) -> Vector:
    if isinstance(thing, Box):
        return thing.length_m, thing.width_m, thing.height_m
    across = 2 * thing.radius_m
    return across, across, across if isinstance(thing, Ball) else thing.height_m


def _rgb(colour: tuple[int, int, int]) -> Vector:
    red, green, blue = (part / 255 for part in colour)
    return red, green, blue


def _add_robot(graph: Graph, robot: RobotDescription, start: Pose) -> None:
    box = robot.body
    base = Transform.turned(start.heading, (start.x, start.y, 0.0))
    size = (box.length_m, box.width_m, box.height_m)
    body = graph.add(Shape(robot.name, size=size, is_static=False, is_respondable=True))
    graph.put(body, base.then(Transform((box.centre_x_m, 0.0, box.clearance_m + box.height_m / 2))))
    if robot.drive:
        _add_wheels(graph, robot.drive, body, base)
    for told in robot.devices:
        if isinstance(told, RangeSensorDescription):
            sensor = ProximitySensor(told.name, reach=told.max_range_m, cone=told.cone_rad)
            graph.put(graph.add(sensor, body), base.then(_at(told.mount)))
        if isinstance(told, CameraDescription):
            eye = VisionSensor(told.name, width=told.width_px, height=told.height_px, angle=told.horizontal_fov_rad)
            graph.put(graph.add(eye, body), base.then(_at(told.mount)))


def _add_wheels(graph: Graph, drive: Drive, body: Shape, base: Transform) -> None:
    for name, side in ((drive.left, 0.5), (drive.right, -0.5)):
        hub = base.then(Transform((0.0, side * drive.track_m, drive.wheel_radius_m), TO_THE_LEFT))
        joint = graph.add(Joint(name, control=JointMode.VELOCITY, lag=0.05), body)
        size = (2 * drive.wheel_radius_m,) * 3
        wheel = graph.add(Shape("wheel", primitive=Primitive.SPHEROID, size=size, is_static=False), joint)
        graph.put(joint, hub)
        graph.put(wheel, hub)


def _at(mount: Mount) -> Transform:
    return Transform.turned(mount.yaw_rad, (mount.x_m, mount.y_m, mount.z_m)).then(Transform((0.0, 0.0, 0.0), AHEAD))

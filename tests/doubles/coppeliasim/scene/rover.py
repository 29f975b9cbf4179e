"""Find and move differential-drive robots: a dynamic body with two velocity-controlled joints that carry wheels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from drivers.kinematic.clearance import Clearance
from drivers.kinematic.motion import Chassis, Wheel
from robotcore.geometry import DifferentialGeometry, Pose
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Joint, JointMode, Node, Primitive, Shape
from tests.doubles.coppeliasim.scene.outlines import (
    GRAVITY_M_S2,
    Contact,
    ContactSensor,
    UprightShape,
    find_lowest_z,
    find_upright_shape,
    nearest_points,
)
from tests.doubles.coppeliasim.scene.poses import Transform, Vector
from tests.doubles.coppeliasim.scene.rendering import Scenery

LEVEL = 0.99
"""The minimum cosine of the angle between the two joint axes of one axle."""


@dataclass(frozen=True)
class Hub:
    """A joint with its wheel: the wheel's centre and the axis of positive rotation, in the world."""

    joint: Joint
    centre: Vector
    axis: Vector
    radius: float


@dataclass(frozen=True)
class Drive:
    """A body on two driven wheels. A sign is -1 if positive rotation of the joint drives backwards.

    ``start`` is the pose of the middle of the axle.
    """

    body: Shape
    left: Joint
    right: Joint
    left_sign: float
    right_sign: float
    start: Pose
    geometry: DifferentialGeometry


def find_drives(graph: Graph) -> list[Drive]:
    """Return the drive of each robot of a scene."""
    hubs: dict[Shape, list[Hub]] = {}
    for joint in graph.all_of(Joint):
        if (body := _find_body(joint)) and (hub := _find_hub(graph, joint)):
            hubs.setdefault(body, []).append(hub)
    return [_create_drive(body, *pair) for body, pair in hubs.items() if _is_axle(pair)]


def _find_body(joint: Joint) -> Shape | None:
    if not (joint.is_dynamic and joint.control == JointMode.VELOCITY):
        return None
    return next((node for node in _iterate_parents(joint) if isinstance(node, Shape) and not node.is_static), None)


def _iterate_parents(node: Node) -> Iterable[Node]:
    while node.parent:
        node = node.parent
        yield node


def _find_hub(graph: Graph, joint: Joint) -> Hub | None:
    """Return the hub of a joint that has a wheel, which is a round dynamic shape below the joint."""
    for node in graph.tree(joint.children):
        if isinstance(node, Shape) and not node.is_static and node.primitive is not Primitive.CUBOID:
            axis = graph.pose(joint).axes[2]
            return Hub(joint, graph.pose(node).position, axis, max(node.size[:2]) / 2)
    return None


def _is_axle(hubs: list[Hub]) -> bool:
    if len(hubs) != 2:
        return False
    one, other = (hub.axis for hub in hubs)
    along = sum(a * b for a, b in zip(one, other, strict=True))
    return abs(along) > LEVEL and abs(one[2]) < 1 - LEVEL


def _create_drive(body: Shape, one: Hub, other: Hub) -> Drive:
    """Return the drive of two hubs. Forward is the direction of positive rotation of the first joint."""
    to_left = one.axis
    left, right = sorted((one, other), key=lambda hub: -_project(hub.centre, to_left))
    middle = [(a + b) / 2 for a, b in zip(left.centre, right.centre, strict=True)]
    return Drive(
        body,
        left.joint,
        right.joint,
        math.copysign(1.0, _project(left.axis, to_left)),
        math.copysign(1.0, _project(right.axis, to_left)),
        Pose(middle[0], middle[1], math.atan2(-to_left[0], to_left[1])),
        DifferentialGeometry(left.radius, _project(left.centre, to_left) - _project(right.centre, to_left)),
    )


def _project(vector: Vector, axis: Vector) -> float:
    return vector[0] * axis[0] + vector[1] * axis[1]


ON_FLOOR_M = 0.002
"""Parts of the robot that end below this height roll or slide on the floor."""


class DrivenWheel:
    """A joint and its wheel. If the target velocity is NaN, the wheel stands still."""

    def __init__(self, joint: Joint, sign: float, step: float) -> None:
        self.wheel = Wheel(joint.lag, step)
        self.joint = joint
        self._sign = sign
        self._start = joint.position

    def command(self) -> None:
        target = self.joint.target_velocity
        self.wheel.target = self._sign * target if math.isfinite(target) else 0.0

    def write_angle(self) -> None:
        """Write the rotation of the wheel to the graph."""
        self.joint.velocity = self._sign * self.wheel.velocity
        self.joint.turn_to(self._start + self._sign * self.wheel.angle)


class Rover:
    """Moves a robot's body and joints in steps of ``step`` seconds."""

    def __init__(self, drive: Drive, graph: Graph, scenery: Scenery, step: float) -> None:
        self._drive, self._graph = drive, graph
        self._left = DrivenWheel(drive.left, drive.left_sign, step)
        self._right = DrivenWheel(drive.right, drive.right_sign, step)
        pose = graph.pose(drive.body)
        base = Transform.rotated(drive.start.heading, (drive.start.x, drive.start.y, 0.0))
        self._body_on_base = base.inverse.compose(pose)
        self._body_shape = _find_upright_body(drive.body, self._body_on_base)
        self._contact_sensor = ContactSensor(self._create_clearance(scenery), drive.start)
        self._chassis = Chassis(drive.start, drive.geometry, self._left.wheel, self._right.wheel, self._contact_sensor)
        self._written_pose = drive.body.local

    def advance(self, count: int) -> None:
        """Simulate ``count`` steps, and move the robot's objects."""
        self._follow_push()
        self._contact_sensor.touching.clear()
        for side in (self._left, self._right):
            side.command()
        for _ in range(count):
            self._chassis.advance()
        for side in (self._left, self._right):
            side.write_angle()
        self._write_poses()

    def set_scenery(self, scenery: Scenery) -> None:
        """Set the scenery that stops the robot."""
        self._contact_sensor.move_to(self._create_clearance(scenery), self._chassis.pose)

    def contacts(self, scenery: Scenery) -> list[Contact]:
        """Return the contacts of the wheels and casters with the floor, and of the body with obstacles."""
        against = [self._create_contact(self._obstacles[i]) for i in sorted(self._contact_sensor.touching)]
        return [*self._find_floor_contacts(scenery), *against]

    def contains(self, node: Node) -> bool:
        """Return whether an object is the robot's body, or below the body in the tree."""
        return node is self._drive.body or (node.parent is not None and self.contains(node.parent))

    def velocity(self, point: Vector) -> tuple[Vector, Vector]:
        """Return the velocity of a point of the body in the world, in m/s, and the body's angular velocity, in rad/s.

        A wheel has the velocity of a fixed part.
        """
        pose, twist = self._chassis.pose, self._chassis.twist
        ahead = (math.cos(pose.heading) * twist.linear, math.sin(pose.heading) * twist.linear)
        x, y = point[0] - pose.x, point[1] - pose.y
        return (ahead[0] - twist.angular * y, ahead[1] + twist.angular * x, 0.0), (0.0, 0.0, twist.angular)

    def _create_clearance(self, scenery: Scenery) -> Clearance:
        self._obstacles = scenery.find_obstacles(self._body_shape.low, self._body_shape.high)
        return Clearance(self._body_shape.outline, scenery.describe(self._obstacles))

    def _follow_push(self) -> None:
        """If a client has moved the body, continue from its new pose."""
        if self._drive.body.local is self._written_pose:
            return
        base = self._graph.pose(self._drive.body).compose(self._body_on_base.inverse)
        self._chassis.pose = Pose(base.position[0], base.position[1], base.yaw)
        self._contact_sensor.move_to(None, self._chassis.pose)

    def _write_poses(self) -> None:
        pose, body = self._chassis.pose, self._drive.body
        base = Transform.rotated(pose.heading, (pose.x, pose.y, 0.0))
        body.local = self._graph.frame(body.parent).inverse.compose(base.compose(self._body_on_base))
        self._written_pose = body.local

    def _find_floor_contacts(self, scenery: Scenery) -> list[Contact]:
        if not scenery.floors:
            return []
        shapes = [node for node in self._graph.tree([self._drive.body]) if isinstance(node, Shape)]
        placed = [(shape, self._graph.pose(shape)) for shape in shapes]
        rolling = [(shape, pose.position) for shape, pose in placed if find_lowest_z(shape, pose) <= ON_FLOOR_M]
        weight = GRAVITY_M_S2 * sum(shape.mass for shape in shapes) / max(len(rolling), 1)
        floor = scenery.floors[0].shape.handle
        return [Contact.of(shape.handle, floor, (x, y, 0.0), (0.0, 0.0, 1.0), weight) for shape, (x, y, _) in rolling]

    def _create_contact(self, other: UprightShape) -> Contact:
        pose, body = self._chassis.pose, self._drive.body
        outline = [pose.to_world(x, y) for x, y in self._body_shape.outline]
        (x, y), (from_x, from_y) = nearest_points(outline, other.outline)
        away = math.hypot(x - from_x, y - from_y) or 1.0
        normal = (float(x - from_x) / away, float(y - from_y) / away, 0.0)
        height = max(self._body_shape.low, other.low)
        return Contact.of(
            body.handle, other.shape.handle, (float(x), float(y), height), normal, GRAVITY_M_S2 * body.mass
        )


def _find_upright_body(body: Shape, pose: Transform) -> UprightShape:
    boxed = replace(body, primitive=Primitive.CUBOID)
    shape = find_upright_shape(body, pose) or find_upright_shape(boxed, Transform.rotated(pose.yaw, pose.position))
    assert shape, "an upright box stands"
    return shape

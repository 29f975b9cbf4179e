"""Find and move differential-drive robots: a dynamic body with two velocity-controlled joints that carry wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drivers.kinematic.clearance import Clearance, CollisionChecker
from drivers.kinematic.motion import Chassis, Wheel
from robotcore.geometry import DifferentialGeometry, Pose
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Joint, JointMode, Node, Shape
from tests.doubles.coppeliasim.scene.poses import Transform, Vector
from tests.doubles.coppeliasim.scene.rendering import PlacedShape, Scenery


@dataclass(frozen=True)
class Drive:
    """A body on two driven wheels. ``start`` is the pose of the centre of the axle."""

    body: Shape
    left: Joint
    right: Joint
    start: Pose
    geometry: DifferentialGeometry


def find_drives(graph: Graph) -> list[Drive]:
    """Return the drive of each robot of a scene."""
    wheels: dict[Shape, list[tuple[Joint, Shape]]] = {}
    for joint in graph.all_of(Joint):
        wheel = next((node for node in joint.children if isinstance(node, Shape)), None)
        body = joint.parent
        if joint.control == JointMode.VELOCITY and wheel and isinstance(body, Shape) and not body.is_static:
            wheels.setdefault(body, []).append((joint, wheel))
    return [_create_drive(graph, body, *pair) for body, pair in wheels.items() if len(pair) == 2]


def _create_drive(graph: Graph, body: Shape, *wheels: tuple[Joint, Shape]) -> Drive:
    """Return the drive of two wheels. The z axes of their joints point to the robot's left."""
    left_x, left_y, _ = graph.pose(wheels[0][0]).axes[2]
    hubs = {joint: graph.pose(joint).position for joint, _ in wheels}
    sideways = {joint: x * left_x + y * left_y for joint, (x, y, _) in hubs.items()}
    right, left = sorted(hubs, key=lambda joint: sideways[joint])
    x, y, _ = ((a + b) / 2 for a, b in zip(hubs[left], hubs[right], strict=True))
    radius = wheels[0][1].size[0] / 2
    geometry = DifferentialGeometry(radius, sideways[left] - sideways[right])
    return Drive(body, left, right, Pose(x, y, math.atan2(-left_x, left_y)), geometry)


class Rover:
    """Moves a robot's body and joints in steps of ``step`` seconds. ``touched`` are the obstacles of the last move."""

    def __init__(self, drive: Drive, graph: Graph, scenery: Scenery, step: float) -> None:
        self.body = drive.body
        self._graph = graph
        self._joints = (drive.left, drive.right)
        self._starts = [joint.position for joint in self._joints]
        self._wheels = [Wheel(joint.lag, step) for joint in self._joints]
        self._body_on_base = _place_base(drive.start).inverse.compose(graph.pose(drive.body))
        body = PlacedShape.of(drive.body, self._body_on_base)
        self._obstacles = [each for each in scenery.obstacles if each.low < body.high and each.high > body.low]
        clearance = Clearance(body.description.outline, scenery.describe(self._obstacles))
        self._collisions = ContactSensor(clearance, drive.start)
        self._chassis = Chassis(drive.start, drive.geometry, self._wheels[0], self._wheels[1], self._collisions)

    def advance(self, count: int) -> None:
        """Simulate ``count`` steps, and move the robot's objects."""
        self._collisions.touching.clear()
        for joint, wheel in zip(self._joints, self._wheels, strict=True):
            wheel.target = joint.target_velocity
        for _ in range(count):
            self._chassis.advance()
        for joint, wheel, start in zip(self._joints, self._wheels, self._starts, strict=True):
            joint.turn_to(start + wheel.angle)
        base = _place_base(self._chassis.pose)
        self.body.local = self._graph.pose(self.body.parent).inverse.compose(base.compose(self._body_on_base))

    @property
    def touched(self) -> list[Node]:
        return [self._obstacles[i].shape for i in sorted(self._collisions.touching)]

    def velocity(self, point: Vector) -> tuple[Vector, Vector]:
        """Return the velocity of a point of the body in the world, in m/s, and the body's angular velocity, in rad/s.

        A wheel has the velocity of a fixed part.
        """
        pose, twist = self._chassis.pose, self._chassis.twist
        ahead = (math.cos(pose.heading) * twist.linear, math.sin(pose.heading) * twist.linear)
        x, y = point[0] - pose.x, point[1] - pose.y
        return (ahead[0] - twist.angular * y, ahead[1] + twist.angular * x, 0.0), (0.0, 0.0, twist.angular)


class ContactSensor(CollisionChecker):
    """A collision checker that records the index of each touched obstacle."""

    def __init__(self, clearance: Clearance, start: Pose) -> None:
        super().__init__(clearance, start)
        self.touching: set[int] = set()

    def try_move(self, here: Pose, there: Pose, distance: float, turn: float) -> bool:
        is_free = super().try_move(here, there, distance, turn)
        if not is_free:
            self.touching.update(np.flatnonzero(self._clearances.measure_gaps(there) < 0).tolist())
        return is_free


def _place_base(pose: Pose) -> Transform:
    return Transform.rotated(pose.heading, (pose.x, pose.y, 0.0))

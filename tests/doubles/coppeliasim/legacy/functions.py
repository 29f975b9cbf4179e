"""The simulator's functions that the legacy plug-in calls (``simGetJointPosition``, …), over the double's scene.

Units are metres, radians and seconds. The functions raise SceneError with the simulator's words.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from tests.doubles.coppeliasim.scene.objects import (
    Joint,
    Node,
    NoObjectError,
    Pixels,
    ProximitySensor,
    SceneError,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Transform, Vector, from_euler, to_euler
from tests.doubles.coppeliasim.scene.rays import Detection
from tests.doubles.coppeliasim.scene.simulator import Simulator

WORLD = -1
"""The handle that stands for the world."""

ALL = -2
"""The handle that stands for all objects."""

TIME_STEP = 1
"""The number of the float parameter for the time step."""

INTEGERS = {1: 41000}
"""The integer parameters by number. Number 1 is the program version, 4.10.0 in the recordings."""

KINDS = {Joint: "a joint", VisionSensor: "a vision sensor", ProximitySensor: "a proximity sensor"}

NodeT = TypeVar("NodeT", bound=Node)


@dataclass(frozen=True)
class Functions:
    """The functions of the simulator that legacy clients call."""

    simulator: Simulator

    def handle(self, name: str) -> int:
        """Return an object's handle by its path, or by its alias or old flat name."""
        graph = self.simulator.graph
        if (node := graph.find(name) if name.startswith("/") else graph.find_flat(name)) is None:
            raise NoObjectError("object does not exist, or alias/path is ill formatted.")
        return node.handle

    def parent(self, handle: int) -> int:
        parent = self.simulator.graph[handle].parent
        return parent.handle if parent else WORLD

    def child(self, handle: int, index: int) -> int:
        """Return the handle of an object's child by the child's index; -1 if there is no such child."""
        children = self.simulator.graph[handle].children
        return children[index].handle if 0 <= index < len(children) else WORLD

    def objects(self, kind: int) -> list[int]:
        """Return the handles of all objects of a type, or of all objects."""
        return [node.handle for node in self.simulator.graph if kind in {node.type, ALL}]

    def joint_position(self, handle: int) -> float:
        return self._one(Joint, handle).position

    def set_joint_position(self, handle: int, position: float) -> None:
        self._one(Joint, handle).position = position
        self.simulator.graph.revision += 1

    def set_joint_target_velocity(self, handle: int, velocity: float) -> None:
        self._one(Joint, handle).target_velocity = velocity

    def detection(self, handle: int) -> Detection | None:
        return self.simulator.detection(self._one(ProximitySensor, handle))

    def picture(self, handle: int) -> Pixels:
        return self.simulator.picture(self._one(VisionSensor, handle))

    def resolution(self, handle: int) -> tuple[int, int]:
        """Return the numbers of rows and columns of a vision sensor's picture."""
        sensor = self._one(VisionSensor, handle)
        return sensor.height, sensor.width

    def show(self, handle: int, picture: Pixels) -> None:
        self.simulator.show(self._one(VisionSensor, handle), picture)

    def position(self, handle: int, relative_to: int) -> Vector:
        return self._pose(handle, relative_to).position

    def set_position(self, handle: int, relative_to: int, position: Vector) -> None:
        self._put(handle, relative_to, Transform(position, self._pose(handle, relative_to).quaternion))

    def orientation(self, handle: int, relative_to: int) -> list[float]:
        """Return the Euler angles alpha, beta and gamma of an object, in radians."""
        return to_euler(self._pose(handle, relative_to).quaternion)

    def set_orientation(self, handle: int, relative_to: int, angles: Vector) -> None:
        self._put(handle, relative_to, Transform(self._pose(handle, relative_to).position, from_euler(angles)))

    def velocity(self, handle: int) -> tuple[Vector, Vector]:
        """Return the linear and the angular velocity in the world."""
        return self.simulator.velocity(self.simulator.graph[handle])

    def floating(self, parameter: int) -> float:
        if parameter != TIME_STEP:
            raise SceneError("invalid parameter.")
        return self.simulator.time_step

    def set_floating(self, parameter: int, value: float) -> None:
        """Set a float parameter. During a simulation a time step is accepted without effect."""
        if parameter != TIME_STEP:
            raise SceneError("invalid parameter.")
        self.simulator.set_time_step(value)

    def integer(self, parameter: int) -> int:
        if parameter not in INTEGERS:
            raise SceneError("invalid parameter.")
        return INTEGERS[parameter]

    def _one(self, kind: type[NodeT], handle: int) -> NodeT:
        node = self.simulator.graph[handle]
        if not isinstance(node, kind):
            raise SceneError(f"object is not {KINDS[kind]}.")
        return node

    def _frame(self, relative_to: int) -> Transform:
        graph = self.simulator.graph
        return Transform() if relative_to == WORLD else graph.pose(graph[relative_to])

    def _pose(self, handle: int, relative_to: int) -> Transform:
        graph = self.simulator.graph
        pose = graph.pose(graph[handle])
        return pose if relative_to == WORLD else self._frame(relative_to).inverse.compose(pose)

    def _put(self, handle: int, relative_to: int, pose: Transform) -> None:
        graph = self.simulator.graph
        graph.put(graph[handle], self._frame(relative_to).compose(pose))

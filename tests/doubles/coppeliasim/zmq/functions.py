"""The ``sim`` functions that the driver calls. The server refuses other functions by their name."""

from __future__ import annotations

import inspect
import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from tests.doubles.coppeliasim.scene import NoObjectError, SceneError, Simulator, State, Ticket
from tests.doubles.coppeliasim.scene.objects import (
    Joint,
    Lamp,
    Node,
    Primitive,
    ProximitySensor,
    Sensor,
    Shape,
    Type,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Transform, normalise
from tests.doubles.coppeliasim.scene.rendering import Detection

INFO = Path(__file__).parents[1] / "recorded" / "sim-info.json"
Numbers = list[float]

ALL, SCENE, TREE = -2, -12, -6
"""The values of the API's ``handle_all``, ``handle_scene`` and ``handle_tree``."""

REVOLUTE, PYRAMID, RAY = 10, 30, 34
TIME_STEP, PHYSICS_STEP, ENGINE, FULL_VERSION, AMBIENT = 1, 5, 8, 39, 5
PHYSICS_STEP_S = 0.005
FIRST_COLLECTION = 2000000
"""The first handle of a collection, far from the handles of objects."""

NO_OBJECT = "object does not exist, or alias/path is ill formatted."
SHAPE_NAMES = {Primitive.CUBOID: "Cuboid", Primitive.SPHEROID: "Sphere", Primitive.CYLINDER: "Cylinder"}
KINDS: dict[type[Node], str] = {
    Joint: "joint",
    Lamp: "light",
    Shape: "shape",
    VisionSensor: "vision sensor",
    ProximitySensor: "proximity sensor",
    Sensor: "sensor",
}
ATTRIBUTES: dict[tuple[type[Node], int], tuple[str, Callable[[Any], Any]]] = {
    (Joint, 2039): ("control", int),
    (ProximitySensor, 4002): ("entity", int),
    (Shape, 3003): ("is_static", bool),
    (VisionSensor, 1004): ("angle", float),
    (VisionSensor, 1008): ("entity", int),
    (VisionSensor, 1018): ("is_perspective", bool),
}
"""The attribute and its type by the number of an object's parameter. Other parameters are stored without effect."""


class NoFunctionError(Exception):
    """The module ``sim`` has no function of this name. A real server does not have it either."""


class PendingReply(Exception):  # noqa: N818  not an error
    """The reply to a call must wait for the end of a step.

    Without a ticket, it must wait until the simulation has stopped.
    """

    def __init__(self, ticket: Ticket | None) -> None:
        super().__init__(ticket)
        self.ticket = ticket

    def is_over(self, simulator: Simulator) -> bool:
        return simulator.is_done(self.ticket) if self.ticket else simulator.state is State.STOPPED


@cache
def load_table() -> dict[str, dict[str, Any]]:
    """Return the table of functions and constants by name: ``{"func": {}}`` or ``{"const": value}``."""
    content: dict[str, dict[str, Any]] = json.loads(INFO.read_text())
    return content


@dataclass
class SharedState:
    """The state that clients share besides the scene: parameters of the simulator by kind and number or name."""

    stored_values: dict[tuple[str, Any], Any] = field(
        default_factory=lambda: {
            ("int", ENGINE): 0,
            ("int", FULL_VERSION): 4100000,
            ("array", AMBIENT): [0.4] * 3,
        }
    )


@dataclass(frozen=True)
class SimFunctions:
    """The functions for one client, such as ``getObject`` as `get_object`.

    A parameter with the type of an object accepts a handle. A result of None is no result, and a tuple has several.
    """

    simulator: Simulator
    shared: SharedState
    client: str

    def call(self, full_name: str, arguments: Sequence[Any]) -> list[Any]:
        """Call a function by its name in the API, and return its results. Raises SceneError if it is refused."""
        name = full_name.removeprefix("sim.")
        if name not in load_table():
            raise NoFunctionError(f"No such function: {full_name}")
        function = getattr(self, re.sub("[A-Z]", lambda capital: f"_{capital[0].lower()}", name), None)
        if function is None:
            raise SceneError("the double of the simulator lacks this function; add it to tests/doubles/coppeliasim.")
        hints = get_type_hints(function)
        names = inspect.signature(function).parameters
        typed = [
            self._convert(hints[name], argument, i)
            for i, (name, argument) in enumerate(zip(names, arguments, strict=False), 1)
        ]
        answer = function(*typed)
        if answer is None:
            return []
        return list(answer) if isinstance(answer, tuple) else [answer]

    def _convert(self, kind: Any, argument: Any, number: int) -> Any:
        """Convert an argument to the type of its parameter, or refuse it in the server's words."""
        is_node = isinstance(kind, type) and issubclass(kind, Node)
        if not is_node and kind is not float:
            return argument
        if isinstance(argument, bool) or not isinstance(argument, (int, float)):
            raise SceneError(f"argument {number} is not a number.")
        if not is_node:
            return float(argument)
        if not isinstance(node := self.simulator.graph[int(argument)], kind):
            raise SceneError(f"object is not a {KINDS[kind]}.")
        return node

    # Joints and shapes

    def set_joint_target_velocity(self, joint: Joint, velocity: float) -> int:
        joint.target_velocity = velocity
        return 1

    def get_joint_target_velocity(self, joint: Joint) -> float:
        return joint.target_velocity

    def get_joint_position(self, joint: Joint) -> float:
        return joint.position

    def set_joint_target_force(self, joint: Joint, force: float) -> None: ...

    def set_joint_interval(self, joint: Joint, is_cyclic: bool, interval: Numbers) -> int:
        joint.is_cyclic = is_cyclic
        return 1

    def set_shape_color(self, shape: Shape, name: Any, component: int, colour: Numbers) -> int:
        red, green, blue = map(float, colour)
        shape.colour = (red, green, blue)
        self.simulator.graph.revision += 1
        return 1

    def set_shape_mass(self, shape: Shape, mass: float) -> None: ...

    def set_shape_inertia(self, shape: Shape, inertia: Numbers, frame: Numbers) -> None: ...

    def set_engine_float_param(self, number: int, node: Node, value: float) -> int:
        return 1

    # Poses in the world

    def get_object_pose(self, node: Node) -> Numbers:
        return self.simulator.graph.pose(node).pose

    def set_object_pose(self, node: Node, pose: Numbers) -> None:
        x, y, z, qx, qy, qz, qw = map(float, pose)
        self.simulator.graph.put(node, Transform((x, y, z), normalise((qx, qy, qz, qw))))

    def get_object_position(self, node: Node) -> Numbers:
        return list(self.simulator.graph.pose(node).position)

    def set_object_position(self, node: Node, position: Numbers) -> None:
        x, y, z = map(float, position)
        graph = self.simulator.graph
        graph.put(node, graph.pose(node)._replace(position=(x, y, z)))

    def get_object_velocity(self, node: Node) -> tuple[Numbers, Numbers]:
        linear, angular = self.simulator.velocity(node)
        return list(linear), list(angular)

    # New objects

    def create_primitive_shape(self, primitive: int, sizes: Numbers, options: int) -> int:
        x, y, z = map(float, sizes)
        kind = Primitive(primitive)
        return self.simulator.graph.add(Shape(SHAPE_NAMES[kind], primitive=kind, size=(x, y, z))).handle

    def create_joint(self, kind: int, mode: int, options: int, sizes: Numbers) -> int:
        if kind != REVOLUTE:
            raise SceneError(f"the double has revolute joints only, not type {kind}.")
        return self.simulator.graph.add(Joint("Revolute_joint")).handle

    def create_force_sensor(self, options: int, ints: list[int], floats: Numbers) -> int:
        return self.simulator.graph.add(Node("forceSensor", Type.FORCE_SENSOR)).handle

    def create_dummy(self, size: float) -> int:
        return self.simulator.graph.add(Node("dummy")).handle

    def create_vision_sensor(self, options: int, ints: list[int], floats: Numbers) -> int:
        """Create a vision sensor. Bits of the options: 0 explicit handling, 1 perspective, 7 own background."""
        if not options & 2:
            raise SceneError("the double has no orthographic vision sensors.")
        (width, height), (near, far, angle, _, _, _, red, green, blue) = ints[:2], map(float, floats[:9])
        sensor = VisionSensor("visionSensor", width=width, height=height, angle=angle, near=near, far=far)
        sensor.explicit = bool(options & 1)
        sensor.background = (red, green, blue) if options & 128 else None
        return self.simulator.graph.add(sensor).handle

    def create_proximity_sensor(self, kind: int, subtype: int, options: int, ints: list[int], floats: Numbers) -> int:
        """Create a proximity sensor. The cone angle of a pyramid is its horizontal opening angle."""
        if kind not in {PYRAMID, RAY}:
            raise SceneError(f"the double has pyramids and rays only, not proximity sensors of type {kind}.")
        reach = float(floats[1])
        sensor = ProximitySensor("proximitySensor", reach=reach, explicit=bool(options & 1), cone=0.0)
        if kind == PYRAMID:
            sensor.cone = 2 * math.atan2((floats[4] - floats[2]) / 2, reach)
        return self.simulator.graph.add(sensor).handle

    # Objects: paths, names, parents, collections and lamps

    def get_object(self, path: str, options: dict[str, Any] | None = None) -> int:
        return self._find_handle(self.simulator.graph.find(path), "1254: in sim._getObject", options)

    def get_object_handle(self, name: str, options: dict[str, Any] | None = None) -> int:
        return self._find_handle(self.simulator.graph.find_flat(name), "1272: in sim._getObjectHandle", options)

    def get_object_type(self, node: Node) -> int:
        return int(node.type)

    def get_object_alias(self, node: Node, option: int) -> str:
        if option != 1:
            raise SceneError(f"the double has no alias of option {option}.")
        return self.simulator.graph.path(node)

    def set_object_alias(self, node: Node, alias: str) -> None:
        node.alias = node.flat_name = alias

    def set_object_parent(self, node: Node, parent: Node, in_place: bool) -> int:
        self.simulator.graph.move_under(node, parent, in_place=in_place)
        return 1

    def get_objects_in_tree(self, root: int, kind: int = ALL, options: int = 0) -> list[int]:
        """Return handles. Bit 1 of the options omits the objects below the first ones."""
        graph = self.simulator.graph
        roots = graph.roots if root == SCENE else [graph[root]]
        found = roots if options & 2 else graph.tree(roots)
        return [node.handle for node in found if kind in {ALL, node.type}]

    def remove_objects(self, handles: list[int]) -> None:
        graph = self.simulator.graph
        if any(handle not in graph for handle in handles):
            raise SceneError("found invalid handles.")
        for handle in handles:
            graph.remove(graph[handle])

    def create_collection(self, options: int) -> int:
        collections = self.simulator.graph.collections
        handle = max(collections, default=FIRST_COLLECTION - 1) + 1
        collections[handle] = set()
        return handle

    def add_item_to_collection(self, handle: int, scope: int, member: Node, options: int) -> None:
        """Add or remove an object or a tree of objects. Bit 0 of the options removes."""
        graph = self.simulator.graph
        nodes = set(graph.tree([member]) if scope == TREE else [member])
        members = self._find_collection(handle)
        graph.collections[handle] = members - nodes if options & 1 else members | nodes
        graph.revision += 1

    def destroy_collection(self, handle: int) -> None:
        self._find_collection(handle)
        del self.simulator.graph.collections[handle]

    def get_light_parameters(self, lamp: Lamp) -> tuple[Any, ...]:
        return lamp.light

    def set_light_parameters(self, lamp: Lamp, state: int, unused: Any, diffuse: Numbers, specular: Numbers) -> None:
        lamp.light = (state, [0.0] * 3, diffuse, specular)

    # Parameters and stored texts

    def get_float_param(self, number: int) -> float:
        return self.simulator.time_step if number == TIME_STEP else PHYSICS_STEP_S

    def set_float_param(self, number: int, value: float) -> int:
        """Set the time step, and return 1. Return 0 unless the simulation is stopped."""
        return int(number == TIME_STEP and self.simulator.set_time_step(value))

    def get_int32_param(self, number: int) -> int:
        return int(self.shared.stored_values["int", number])

    def set_int32_param(self, number: int, value: int) -> int:
        self.shared.stored_values["int", number] = value
        return 1

    def get_array_param(self, number: int) -> Numbers:
        return list(self.shared.stored_values["array", number])

    def set_array_param(self, number: int, values: Numbers) -> int:
        self.shared.stored_values["array", number] = values
        return 1

    def get_named_string_param(self, name: str) -> bytes | None:
        value = self.shared.stored_values.get(("named", name))
        return None if value is None else value.encode()

    def set_named_string_param(self, name: str, value: str) -> int:
        self.shared.stored_values["named", name] = value
        return 1

    def get_object_int32_param(self, node: Node, number: int) -> int:
        return int(self._read_parameter(node, number))

    def get_object_float_param(self, node: Node, number: int) -> float:
        return float(self._read_parameter(node, number))

    def set_object_int32_param(self, node: Node, number: int, value: int) -> int:
        if attribute := ATTRIBUTES.get((type(node), number)):
            name, kind = attribute
            setattr(node, name, kind(value))
            self.simulator.graph.revision += 1
        node.parameters[number] = value
        return 1

    def read_custom_string_data(self, node: Node, tag: str) -> Any:
        return node.parameters.get(tag)

    def write_custom_string_data(self, node: Node, tag: str, text: str) -> int:
        node.parameters[tag] = text
        return 1

    # Sensors and contacts

    def get_vision_sensor_img(self, sensor: VisionSensor, options: int = 0) -> tuple[bytes, list[int]]:
        """Return the pixels, RGB or grey (bit 0 of the options), the lowest row first, and the size of the sensor."""
        picture = self.simulator.picture(sensor)
        if options & 1:
            picture = picture.mean(axis=2).astype(np.uint8)
        return picture.tobytes(), [sensor.width, sensor.height]

    def set_vision_sensor_img(self, sensor: VisionSensor, pixels: bytes) -> int:
        if len(pixels) != sensor.width * sensor.height * 3:
            raise SceneError("incorrect buffer size.")
        self.simulator.show(sensor, np.frombuffer(pixels, np.uint8).reshape(sensor.height, sensor.width, 3))
        return 1

    def get_vision_sensor_res(self, sensor: VisionSensor) -> list[int]:
        return [sensor.width, sensor.height]

    def get_vision_sensor_depth(self, sensor: VisionSensor, options: int = 0) -> tuple[bytes, list[int]]:
        """Return depths, in metres if bit 0 of the options is set.

        Otherwise a depth is 0 at the near plane and 1 at the far plane.
        """
        depths = self.simulator.depth(sensor)
        if not options & 1:
            depths = (depths - sensor.near) / (sensor.far - sensor.near)
        return depths.astype("<f4").tobytes(), [sensor.width, sensor.height]

    def handle_vision_sensor(self, sensor: VisionSensor) -> tuple[int, Numbers, Numbers]:
        """Render a picture. The statistics of the picture are missing in the result, because no driver reads them."""
        self.simulator.handle(sensor)
        return 0, [], []

    def get_explicit_handling(self, sensor: Sensor) -> int:
        return int(sensor.explicit)

    def set_explicit_handling(self, sensor: Sensor, is_explicit: int) -> int:
        sensor.explicit = bool(is_explicit)
        return 1

    def read_proximity_sensor(self, sensor: ProximitySensor) -> tuple[Any, ...]:
        """Return the detection in the last step. While the simulation is stopped, nothing is detected."""
        is_stopped = self.simulator.state is State.STOPPED
        return _describe_detection(None if is_stopped else self.simulator.detection(sensor))

    def handle_proximity_sensor(self, sensor: ProximitySensor) -> tuple[Any, ...]:
        if not sensor.explicit:
            raise SceneError("object not tagged for explicit handling.")
        return _describe_detection(self.simulator.detection(sensor))

    def get_contact_info(self, passes: int, shape: int, index: int) -> tuple[list[Any], ...]:
        """Return the two shapes of a contact, its point, force and normal. The result is empty after the last contact.

        The double has contacts of robots' bodies only. Their points, forces and normals are zeros.
        """
        pairs = [[one.handle, other.handle] for one, other in self.simulator.contacts()]
        if shape != ALL:
            pairs = [[shape, sum(pair) - shape] for pair in pairs if shape in pair]
        return (pairs[index], [0.0] * 3, [0.0] * 3, [0.0] * 3) if index < len(pairs) else ([], [], [], [])

    # The simulation

    def start_simulation(self) -> None:
        self.simulator.start()

    def pause_simulation(self) -> None:
        self.simulator.pause()

    def stop_simulation(self, wait: bool = False) -> None:  # noqa: FBT002  as in the API
        self.simulator.stop()
        if wait:
            raise PendingReply(None)

    def get_simulation_state(self) -> int:
        return int(self.simulator.state)

    def get_simulation_time(self) -> float:
        return self.simulator.time

    def get_simulation_time_step(self) -> float:
        return self.simulator.time_step

    def set_stepping(self, is_on: bool) -> int:
        """Raise or lower the client's stepping level, and return the previous one."""
        return self.simulator.hold(self.client) if is_on else self.simulator.release(self.client)

    def step(self, wait: bool = True) -> None:  # noqa: FBT002  as in the API
        raise PendingReply(self.simulator.step(self.client))

    def _find_handle(self, node: Node | None, where: str, options: dict[str, Any] | None) -> int:
        """Return the handle of a found object. The server's error names its inner function ``where``."""
        if node:
            return node.handle
        if (options or {}).get("noError"):
            return -1
        raise NoObjectError(NO_OBJECT, where)

    def _find_collection(self, handle: int) -> set[Node]:
        if handle not in self.simulator.graph.collections:
            raise SceneError("collection does not exist.")
        return self.simulator.graph.collections[handle]

    def _read_parameter(self, node: Node, number: int) -> Any:
        if attribute := ATTRIBUTES.get((type(node), number)):
            return getattr(node, attribute[0])
        if number not in node.parameters:
            raise SceneError(f"the double has no value of parameter {number} of {node.alias}, because it was not set.")
        return node.parameters[number]


def _describe_detection(detection: Detection | None) -> tuple[int, float, Numbers, int, Numbers]:
    """Return the state, the distance, the point and the object of a detection, and a normal, which is not computed."""
    if detection is None:
        return 0, 0.0, [0.0] * 3, -1, [0.0] * 3
    return 1, detection.distance, list(detection.point), detection.handle, [0.0] * 3

"""The commands of the legacy remote API over the double's scene. Units are metres, radians and seconds."""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable, Container, Hashable
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from tests.doubles.coppeliasim.legacy.codec import Code, Command
from tests.doubles.coppeliasim.scene import NoObjectError, SceneError, Simulator
from tests.doubles.coppeliasim.scene.objects import Joint, Node, Pixels, ProximitySensor, VisionSensor
from tests.doubles.coppeliasim.scene.poses import to_euler

WORLD, EVERYTHING = -1, 109
NAMES, TYPES = 0, 1
TIME_STEP = 1
INTEGERS = {1: 41000}
"""The integer parameters of the simulator. Number 1 is the program version, 4.10.0 in the recordings."""
SENSOR_PARAMETERS = {1002: "width", 1003: "height", 1004: "angle"}
KINDS = {Joint: "a joint", VisionSensor: "a vision sensor", ProximitySensor: "a proximity sensor"}
ERRORS_KEPT = 50

INT = struct.Struct("<i")
FLOAT = struct.Struct("<f")
FLOATS3 = struct.Struct("<3f")
TWO_INTS = struct.Struct("<2i")
DETECTION = struct.Struct("<b3fi3f")

NO_DETECTION = DETECTION.pack(0, 0.0, 3.640625, -1.6e-23, 0, -5481547.5, 1.62, -6.1e-12)
"""The data that the real server has sent without a detection. Only the first byte is valid."""

NodeT = TypeVar("NodeT", bound=Node)


class RefusedError(Exception):
    """A command failed without an error text."""


class CommandExecutor:
    """Executes the commands of one client, and stores the errors of its calls.

    client: the client that steps.
    """

    def __init__(self, simulator: Simulator, client: Hashable) -> None:
        self._simulator, self._client = simulator, client
        self._errors: deque[str] = deque(maxlen=ERRORS_KEPT)
        self._signals: dict[tuple[str, bytes], float] = {}
        self._is_triggered = False

    def execute(self, command: Command) -> Command:
        """Execute a command, and return its answer."""
        sim_ms = round(self._simulator.time * 1000) if self._simulator.state else 0
        handler = HANDLERS.get(command.code, UNKNOWN)
        try:
            data, status = handler.execute(self, command), 0
        except SceneError as error:
            self._errors.append(f"{error} ({handler.function})")
            data, status = handler.failure, 1
        except (RefusedError, struct.error):  # too few bytes
            data, status = handler.failure, 1
        return replace(command, data=data, status=status, sim_ms=sim_ms, delay_ms=0)

    def step(self) -> None:
        """Simulate the requested time step."""
        if self._is_triggered:
            self._is_triggered = False
            self._simulator.step(self._client)

    # Objects

    def find(self, command: Command) -> bytes:
        """Find an object by its path, or by its alias or flat name."""
        name, graph = command.identity.split(b"\0")[0].decode(errors="replace"), self._simulator.graph
        if (node := graph.find(name) if name.startswith("/") else graph.find_flat(name)) is None:
            raise NoObjectError("object does not exist, or alias/path is ill formatted.")
        return INT.pack(node.handle)

    def read_group(self, command: Command) -> bytes:
        """Return the counts of handles, integers, floats and texts, and then these values."""
        kind, what = TWO_INTS.unpack_from(command.identity)
        nodes = [node for node in self._simulator.graph if kind in {EVERYTHING, node.type}]
        numbers = [int(node.type) for node in nodes] if what == TYPES else []
        texts = [node.alias for node in nodes] if what == NAMES else []
        whole = [len(nodes), len(numbers), 0, len(texts), *(node.handle for node in nodes), *numbers]
        return struct.pack(f"<{len(whole)}i", *whole) + b"".join(text.encode() + b"\0" for text in texts)

    def read_position(self, command: Command) -> bytes:
        return FLOATS3.pack(*self._simulator.graph.pose(self._read_node(command)).position)

    def read_orientation(self, command: Command) -> bytes:
        """Return the Euler angles alpha, beta and gamma."""
        return FLOATS3.pack(*to_euler(self._simulator.graph.pose(self._read_node(command)).quaternion))

    def read_sensor_parameter(self, command: Command) -> bytes:
        handle, number = TWO_INTS.unpack_from(command.identity)
        sensor = self._simulator.graph[handle]
        if not isinstance(sensor, VisionSensor) or number not in SENSOR_PARAMETERS:
            raise RefusedError
        value = getattr(sensor, SENSOR_PARAMETERS[number])
        return (FLOAT if command.code == Code.GET_OBJECT_FLOAT_PARAMETER else INT).pack(value)

    # Joints and sensors

    def read_joint_position(self, command: Command) -> bytes:
        return FLOAT.pack(self._find(Joint, command).position)

    def set_joint_target_velocity(self, command: Command) -> bytes:
        (velocity,) = FLOAT.unpack_from(command.data)
        self._find(Joint, command).target_velocity = velocity
        return b""

    def read_proximity_sensor(self, command: Command) -> bytes:
        """Return the 29 bytes of a reading: a byte 0 or 1, the point, the object's handle, the normal.

        No recording has a detection. Sources: the plug-in (``simxCmd.cpp``, read_proximity_sensor) and the
        official binding's documentation of ``simxReadProximitySensor``. The distance is the norm of the point. The
        double does not compute the normal.
        """
        found = self._simulator.detection(self._find(ProximitySensor, command))
        return DETECTION.pack(1, *found.point, found.handle, 0.0, 0.0, 0.0) if found else NO_DETECTION

    def read_vision_sensor(self, command: Command) -> bytes:
        """Refuse without a text, as the real server does while it is stopped.

        No recording has an answer during a run.
        """
        self._find(VisionSensor, command)
        raise RefusedError

    def read_colours(self, command: Command) -> bytes:
        return _encode_picture(self._simulator.picture(self._find(VisionSensor, command)))

    def read_greys(self, command: Command) -> bytes:
        """Return the mean of the three colours, rounded down, as the server does."""
        picture = self._simulator.picture(self._find(VisionSensor, command))
        return _encode_picture((picture.sum(axis=2, dtype=np.uint16) // 3).astype(np.uint8))

    def show_colours(self, command: Command) -> bytes:
        return self._show(command, channels=3)

    def show_greys(self, command: Command) -> bytes:
        return self._show(command, channels=1)

    def _show(self, command: Command, channels: int) -> bytes:
        sensor = self._find(VisionSensor, command)
        shape = (sensor.height, sensor.width)
        if len(command.data) != sensor.height * sensor.width * channels:
            raise RefusedError
        pixels = np.frombuffer(command.data, np.uint8).reshape(*shape, channels)
        self._simulator.show(sensor, np.broadcast_to(pixels, (*shape, 3)))
        return b""

    # Parameters and signals

    def read_integer(self, command: Command) -> bytes:
        return INT.pack(INTEGERS[self._read_number(command, INTEGERS)])

    def read_floating(self, command: Command) -> bytes:
        self._read_number(command, {TIME_STEP})
        return FLOAT.pack(self._simulator.time_step)

    def set_floating(self, command: Command) -> bytes:
        """Set the time step. During a simulation it is accepted without effect."""
        self._read_number(command, {TIME_STEP})
        self._simulator.set_time_step(*FLOAT.unpack_from(command.data))
        return b""

    def read_signal(self, command: Command) -> bytes:
        """Return the value of a signal. A missing signal is an error without a text."""
        layout = FLOAT if command.code == Code.GET_FLOAT_SIGNAL else INT
        if (layout.format, command.identity) not in self._signals:
            raise RefusedError
        return layout.pack(self._signals[layout.format, command.identity])

    def set_signal(self, command: Command) -> bytes:
        layout = FLOAT if command.code == Code.SET_FLOAT_SIGNAL else INT
        (self._signals[layout.format, command.identity],) = layout.unpack_from(command.data)
        return b""

    # The simulation

    def start_pause_stop(self, command: Command) -> bytes:
        (number,) = INT.unpack_from(command.identity)
        requests = (self._simulator.start, self._simulator.pause, self._simulator.stop)
        if not 0 <= number < len(requests):
            raise RefusedError
        requests[number]()
        return b""

    def hold_time(self, command: Command) -> bytes:
        """Make time wait for triggers, until the client ends stepping or the simulation stops."""
        if not self._simulator.level(self._client):
            self._simulator.hold(self._client)
        return b""

    def release_time(self, command: Command) -> bytes:
        self._simulator.leave(self._client)
        return b""

    def trigger(self, command: Command) -> bytes:
        """Request a time step, which follows the other commands of the message.

        Returns an error if the client does not step, or if the simulation is stopped.
        """
        if not self._simulator.level(self._client) or not self._simulator.state.is_advancing:
            raise RefusedError
        self._is_triggered = True
        return b""

    def read_last_errors(self, command: Command) -> bytes:
        """Return the number of errors and their texts, and clear them."""
        texts = [error.encode() + b"\0" for error in self._errors]
        self._errors.clear()
        return INT.pack(len(texts)) + b"".join(texts)

    def _find(self, kind: type[NodeT], command: Command) -> NodeT:
        node = self._read_node(command)
        if not isinstance(node, kind):
            raise SceneError(f"object is not {KINDS[kind]}.")
        return node

    def _read_node(self, command: Command) -> Node:
        """Return the object in the key of a command. A second handle must be the world."""
        handle, *relative_to = struct.unpack(f"<{len(command.identity) // 4}i", command.identity)
        if relative_to not in ([], [WORLD]):
            raise RefusedError
        return self._simulator.graph[handle]

    def _read_number(self, command: Command, known: Container[int]) -> int:
        (number,) = INT.unpack_from(command.identity)
        if number not in known:
            raise SceneError("invalid parameter.")
        return int(number)


class Handler(NamedTuple):
    """The method that executes a command, the simulator's function in its error texts, and the data of a refusal."""

    execute: Callable[[CommandExecutor, Command], bytes]
    function: str = ""
    failure: bytes = b""


def _refuse(executor: CommandExecutor, command: Command) -> bytes:
    raise RefusedError


def _encode_picture(pixels: Pixels) -> bytes:
    """Return width, height and the pixels, the lowest row first."""
    return TWO_INTS.pack(pixels.shape[1], pixels.shape[0]) + pixels.tobytes()


_DO = CommandExecutor
_ZERO = bytes(4)
_RESOLUTION = "simGetVisionSensorResolution"
UNKNOWN = Handler(_refuse)
HANDLERS: dict[int, Handler] = {
    Code.GET_OBJECT_HANDLE: Handler(_DO.find, "simGetObjectHandle", INT.pack(-1)),
    Code.GET_OBJECT_GROUP_DATA: Handler(_DO.read_group),
    Code.GET_OBJECT_POSITION: Handler(_DO.read_position, "simGetObjectPosition", bytes(12)),
    Code.GET_OBJECT_ORIENTATION: Handler(_DO.read_orientation, "simGetObjectOrientation", bytes(12)),
    Code.GET_OBJECT_INT_PARAMETER: Handler(_DO.read_sensor_parameter, "simGetObjectInt32Parameter", _ZERO),
    Code.GET_OBJECT_FLOAT_PARAMETER: Handler(_DO.read_sensor_parameter, "simGetObjectFloatParameter", _ZERO),
    Code.GET_JOINT_POSITION: Handler(_DO.read_joint_position, "simGetJointPosition", _ZERO),
    Code.SET_JOINT_TARGET_VELOCITY: Handler(_DO.set_joint_target_velocity, "simSetJointTargetVelocity"),
    Code.READ_PROXIMITY_SENSOR: Handler(_DO.read_proximity_sensor, "simReadProximitySensor", NO_DETECTION),
    Code.READ_VISION_SENSOR: Handler(_DO.read_vision_sensor, _RESOLUTION, _ZERO),
    Code.GET_VISION_SENSOR_IMAGE_RGB: Handler(_DO.read_colours, _RESOLUTION),
    Code.GET_VISION_SENSOR_IMAGE_BW: Handler(_DO.read_greys, _RESOLUTION),
    Code.SET_VISION_SENSOR_IMAGE_RGB: Handler(_DO.show_colours, _RESOLUTION),
    Code.SET_VISION_SENSOR_IMAGE_BW: Handler(_DO.show_greys, _RESOLUTION),
    Code.GET_INTEGER_PARAMETER: Handler(_DO.read_integer, "simGetIntegerParameter", _ZERO),
    Code.GET_FLOATING_PARAMETER: Handler(_DO.read_floating, "simGetFloatingParameter", _ZERO),
    Code.SET_FLOATING_PARAMETER: Handler(_DO.set_floating, "simSetFloatingParameter"),
    Code.GET_FLOAT_SIGNAL: Handler(_DO.read_signal, failure=_ZERO),
    Code.GET_INTEGER_SIGNAL: Handler(_DO.read_signal, failure=_ZERO),
    Code.SET_FLOAT_SIGNAL: Handler(_DO.set_signal),
    Code.SET_INTEGER_SIGNAL: Handler(_DO.set_signal),
    Code.START_PAUSE_STOP_SIMULATION: Handler(_DO.start_pause_stop),
    Code.SYNCHRONOUS_ENABLE: Handler(_DO.hold_time),
    Code.SYNCHRONOUS_DISABLE: Handler(_DO.release_time),
    Code.SYNCHRONOUS_NEXT: Handler(_DO.trigger),
    Code.GET_LAST_ERRORS: Handler(_DO.read_last_errors),
}

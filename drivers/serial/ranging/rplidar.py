"""The driver of Slamtec's RPLIDAR A1, which measures after a request.

Requests are two bytes: a5 25 stops, a5 52 asks for the health, a5 20 starts the scan. The answer to a request is a
descriptor of seven bytes, and its data. The stop has no answer. The data of a scan are nodes of five bytes:

    quality, not start, start    angle, 1    angle    distance    distance

The first byte has the quality in its upper six bits, then a bit that is the inverse of the next one, and a bit that is
1 for the first node of a revolution. The angle is in 64ths of a degree, clockwise; its lower seven bits are followed by
a bit that is always 1. The distance is in quarters of a millimetre; 0 means no echo. There is no checksum.

On the A1's USB adapter, the line DTR stops the motor.

Source: Slamtec, RPLIDAR Interface Protocol and Application Notes, applied to RPLIDAR A1 & A2, rev. 1.1, chapters
"Scan request", "Stop request", "Device health" and RPLIDAR A1 Development Kit User Manual, rev. 1.1 (MOTOCTL).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum, auto
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from drivers.serial.ranging.frames import FULL_BUFFER_BYTES
from drivers.serial.ranging.lidar import Array, LidarDriver, ScanBuilder, SerialLidar
from robotcore.hardware import DeviceContext
from robotcore.kinds.lidar import Lidar, LidarDescription

STOP, HEALTH, SCAN = b"\xa5\x25", b"\xa5\x52", b"\xa5\x20"
HEALTH_ANSWER, SCAN_ANSWER = bytes.fromhex("a5 5a 03 00 00 00 06"), bytes.fromhex("a5 5a 05 00 00 40 81")
HEALTH_SIZE, NODE_SIZE = 3, 5

PROTECTED = 2
"""The health of a lidar that has stopped itself after an error."""

MIN_VALID_NODES = 8
"""The number of valid nodes in a row of which the first is accepted."""

_CIRCLE = 360 * 64


class Node(NamedTuple):
    """A measurement of the lidar."""

    is_first: bool
    """Whether it is the first of a revolution."""
    angle: float
    """The angle in degrees, clockwise. It is not reliable without an echo."""
    distance: float
    """The distance in metres; ``inf`` without an echo."""


class NodeParser:
    """Splits the stream of a scan into nodes.

    The nodes have no checksum, but three bits of them are known. A node is accepted if it and the next ones are valid,
    `MIN_VALID_NODES` in all. The first one at the beginning and after lost bytes is dropped.

    >>> parser = NodeParser()
    >>> parser.feed(bytes.fromhex("3e 01 2d a0 0f") * 9)
    [Node(is_first=False, angle=90.0, distance=1.0)]
    """

    def __init__(self) -> None:
        self.losses = 0
        """How often the parser has lost the beginning of the nodes."""
        self._rest = b""
        self._checked = 0

    def feed(self, data: bytes) -> list[Node]:
        """Parse received bytes; return the nodes that these bytes complete."""
        stream, at, nodes = self._rest + data, 0, []
        while at + NODE_SIZE * MIN_VALID_NODES <= len(stream):
            if all(_is_node(stream, at + NODE_SIZE * index) for index in range(self._checked, MIN_VALID_NODES)):
                if self._checked:  # otherwise its first byte may be the last one of a damaged node
                    nodes.append(_parse_node(stream, at))
                at, self._checked = at + NODE_SIZE, MIN_VALID_NODES - 1
            else:
                self.losses += self._checked > 0
                at, self._checked = at + 1, 0
        self._rest = stream[at:]
        return nodes


def _is_node(stream: bytes, at: int) -> bool:
    flags, low, high = stream[at : at + 3]
    return (flags & 1) != (flags >> 1 & 1) and low & 1 == 1 and (low >> 1 | high << 7) < _CIRCLE


def _parse_node(stream: bytes, at: int) -> Node:
    flags, low, high, distance_low, distance_high = stream[at : at + NODE_SIZE]
    quarters = distance_low | distance_high << 8
    return Node(bool(flags & 1), (low >> 1 | high << 7) / 64, quarters / 4000 if quarters else math.inf)


class _State(Enum):
    STOPPING = auto()
    CHECKING_HEALTH = auto()
    STARTING = auto()
    SCANNING = auto()


class RPLidarProtocol(Protocol):
    """Starts the scan, and collects the nodes into revolutions. The protocol is ready when nodes arrive.

    It first stops the lidar, because a killed program may have left it scanning. A lidar that does not answer, or stops
    sending, is stopped and asked again.
    """

    dtr = False  # the level at which the motor turns

    def __init__(self, builder: ScanBuilder, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self._builder, self._parser = builder, NodeParser()
        self._is_closing = False
        self._error_code: int | None = None
        self._has_started = False
        self._state, self._deadline = _State.STOPPING, 0.0
        self._answer, self._request = b"", STOP
        self._revolution: list[Node] | None = None
        self._revolution_at = 0.0

    def begin(self, now: float) -> None:
        self.is_ready = self._has_started = False
        self._error_code = None
        self._enter(_State.STOPPING, now)

    def stop(self) -> None:
        """Send the stop as the next and last data."""
        self._is_closing = True

    def receive(self, data: bytes, now: float) -> None:
        if self._state is _State.SCANNING:
            self._receive_nodes(data, now)
            return
        self._answer += data
        if self._state is _State.CHECKING_HEALTH and (health := _find_answer(self._answer, HEALTH_ANSWER, HEALTH_SIZE)):
            self._error_code = int.from_bytes(health[1:3], "little") if health[0] == PROTECTED else None
            self._enter(_State.STARTING, now)
        elif self._state is _State.STARTING and SCAN_ANSWER in self._answer:
            nodes = self._answer.partition(SCAN_ANSWER)[2]
            self._has_started = True
            self._enter(_State.SCANNING, now)
            self._receive_nodes(nodes, now)
        self._answer = self._answer[-_MAX_ANSWER:]

    def data_to_send(self, now: float) -> bytes:
        if self._is_closing:
            return STOP
        if self._request:
            request, self._request = self._request, b""
            return request
        if now < self._deadline:
            return b""
        if self._state is _State.STOPPING:
            self._enter(_State.CHECKING_HEALTH, now)
        else:
            self._has_started = self._has_started and self._state is not _State.CHECKING_HEALTH
            self.is_ready = False
            self._enter(_State.STOPPING, now)
        return self.data_to_send(now)

    def next_due(self, now: float) -> float:
        return now if self._request or self._is_closing else self._deadline

    def explain_silence(self, place: str, *, has_received: bool = False) -> str:
        if self._error_code is not None:
            return f"the lidar on {place} has stopped itself with the error {self._error_code:#06x}. Replug it"
        if self._has_started:
            return f"the lidar on {place} answers, but does not measure. Check that its motor turns freely"
        if has_received:
            return (
                f"the data on {place} at {self.baud} baud is not that of an RPLIDAR. Check that this is the lidar's "
                "port, and that baud is 115200 for an A1"
            )
        return f"nothing on {place} answers at {self.baud} baud. Check the lidar's plugs, and that this is its port"

    def _enter(self, state: _State, now: float) -> None:
        self._state, self._answer = state, b""
        self._request, wait_s = _REQUESTS[state]
        self._deadline = now + wait_s
        self._parser, self._revolution = NodeParser(), None

    def _receive_nodes(self, data: bytes, now: float) -> None:
        losses = self._parser.losses
        nodes = self._parser.feed(data)
        if self._parser.losses > losses or len(data) >= FULL_BUFFER_BYTES:
            self._revolution = None
            return
        for node in nodes:
            if node.is_first:
                self._end_revolution()
                self._revolution, self._revolution_at = [], now
            if self._revolution is not None and len(self._revolution) < _MAX_NODES:
                self._revolution.append(node)
        if nodes:
            self.is_ready, self._deadline = True, now + _SILENCE_S

    def _end_revolution(self) -> None:
        if not self._revolution:
            return
        angles, distances = (np.array(each) for each in list(zip(*self._revolution, strict=True))[1:])
        self._builder.add_revolution(_spread_angles(angles, np.isfinite(distances)), distances, self._revolution_at)


def _spread_angles(angles: Array, is_echo: NDArray[np.bool_]) -> Array:
    """Return the angles of a revolution in degrees, in which those without an echo lie evenly between their neighbours.

    The first angle of a revolution may be a little less than 360, and the last ones a little more than 0.
    """
    count, echoes = len(angles), np.flatnonzero(is_echo)
    turns = np.rint(echoes / count - angles[echoes] / 360)
    known = [0.0, *(angles[echoes] + 360 * turns), 360.0]
    spread: Array = np.interp(np.arange(count), [-1, *echoes, count], known)
    return spread


def _find_answer(received: bytes, descriptor: bytes, size: int) -> bytes:
    """Return the data after a descriptor; empty if they have not arrived."""
    data = received.partition(descriptor)[2]
    return data[:size] if len(data) >= size else b""


_MAX_ANSWER = 100
"""The number of received bytes in which an answer is searched."""

_MAX_NODES = 4000
"""The largest number of nodes that are stored for a revolution. The lidar sends 200 to 1500 nodes in one."""

_SILENCE_S = 0.5
"""A lidar that is silent for this many seconds while it scans is lost."""

_REQUESTS = {
    _State.STOPPING: (STOP, 0.05),
    _State.CHECKING_HEALTH: (HEALTH, 0.5),
    _State.STARTING: (SCAN, 0.5),
    _State.SCANNING: (b"", 4.0),
}
"""For each state, the request at its beginning, and its longest duration in seconds without data.

The scan begins when the motor has reached its speed, which takes about two seconds.
"""

_ANSWER_S, _FIRST_S = 8.0, 2.0
"""The longest wait for the first nodes, and for the first scan after that, in seconds."""


class _RPLidar(SerialLidar):
    def __init__(self, lidar: LidarDescription, builder: ScanBuilder, line: Line, protocol: RPLidarProtocol) -> None:
        super().__init__(lidar, builder, line)
        self._protocol = protocol

    def _release(self) -> None:
        self._protocol.stop()
        super()._release()


class RPLidarA1(LidarDriver):
    """Opens an RPLIDAR A1 on its USB adapter. Closing it stops the laser and the motor."""

    name = "rplidar-a1"
    summary = "RPLIDAR A1: a lidar up to 12 m, on its USB adapter"
    aliases = ("rplidar", "slamtec", "a1m8")
    protocol_name = "RPLIDAR"
    default_baud = 115200

    def notes(self, description: LidarDescription) -> Sequence[str]:
        return (_DIRECTION,)

    def open(self, description: LidarDescription, context: DeviceContext) -> Lidar:
        builder = ScanBuilder(description)
        protocol = RPLidarProtocol(builder, self.effective_baud)
        lidar = _RPLidar(description, builder, Line(self.port, protocol, context.clock), protocol)
        lidar.open(_ANSWER_S, _FIRST_S)
        return lidar


_DIRECTION = (
    "The bearing 0 is the angle 0 in the lidar's manual. Put a thing in front of the robot, the nearest of all: "
    "robotcore doctor prints its bearing. mount.yaw_rad is the negative of this angle, in radians."
)

"""The driver of LDRobot's lidars LD06 and LD19, which send packets of 47 bytes as long as they have power.

    54 2c  speed  start  12 × (distance  intensity)  end  time  check

All numbers but the intensity have two bytes, the low byte first. The speed is in degrees per second. The start and the
end are the angles of the first and the last point in hundredths of a degree, clockwise. A distance is in millimetres; 0
means no echo. The time is in milliseconds, and begins again at 30000. The check is a CRC of the other 46 bytes with
the polynomial 0x4d.

Source: LDROBOT LD06 and LD19 Development Manual, chapters "Communication protocol" and "Packet format"; also on
https://www.inno-maker.com/product/lidar-ld06/.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from drivers.serial.ranging.frames import FULL_BUFFER_BYTES, FrameParser
from drivers.serial.ranging.lidar import Array, LidarDriver, ScanBuilder, SerialLidar
from robotcore.hardware import DeviceContext
from robotcore.kinds.lidar import Lidar, LidarDescription

POINTS_PER_PACKET = 12

_FIELDS = struct.Struct("<2xHH36sHHB")
_POINT = struct.Struct("<HB")

_CIRCLE = 36000
"""A full circle, in hundredths of a degree."""

_MAX_SPAN = 3000
"""The largest angle of a packet, in hundredths of a degree. The fastest lidar turns by 13° in a packet."""

TIME_WRAP_MS = 30000
"""The time in a packet begins again at this number of milliseconds."""


def _build_crc_table(polynomial: int) -> bytes:
    table = bytearray(range(256))
    for _ in range(8):
        table = bytearray((crc << 1 ^ polynomial if crc & 0x80 else crc << 1) & 0xFF for crc in table)
    return bytes(table)


_CRC = _build_crc_table(0x4D)


def compute_crc(data: bytes) -> int:
    r"""Return the check byte of the first 46 bytes of a packet.

    >>> hex(compute_crc(b"\x54\x2c"))
    '0xd8'
    """
    crc = 0
    for byte in data:
        crc = _CRC[crc ^ byte]
    return crc


@dataclass(frozen=True)
class Packet:
    """The content of a packet from the lidar."""

    speed: int
    """The speed of the lidar, in degrees per second."""
    start: int
    """The angle of the first point, in hundredths of a degree, clockwise."""
    distances: tuple[int, ...]
    """The distance of each point, in millimetres; 0 without an echo."""
    end: int
    """The angle of the last point, in hundredths of a degree, clockwise."""
    time_ms: int
    """The time of the packet, in milliseconds."""

    @property
    def angles(self) -> Array:
        """The angle of each point, in degrees from 0 to 360, clockwise."""
        span = (self.end - self.start) % _CIRCLE
        offsets = np.arange(POINTS_PER_PACKET) * (span / (POINTS_PER_PACKET - 1))
        angles: Array = np.mod(self.start + offsets, _CIRCLE) / 100
        return angles


class Parser(FrameParser[Packet]):
    """Splits a stream of bytes into packets."""

    header, size = b"\x54\x2c", 47

    def parse(self, frame: bytes) -> Packet | None:
        if compute_crc(frame[:-1]) != frame[-1]:
            return None
        speed, start, points, end, time_ms, _ = _FIELDS.unpack(frame)
        is_possible = start < _CIRCLE and end < _CIRCLE and (end - start) % _CIRCLE <= _MAX_SPAN
        distances = tuple(distance for distance, _ in _POINT.iter_unpack(points))
        return Packet(speed, start, distances, end, time_ms) if is_possible else None


class LD06Protocol(Protocol):
    """Collects the points of packets into revolutions. The protocol is ready after two packets in a row.

    A lidar that has sent nothing for `_SILENCE_S` seconds is lost. The protocol sends nothing, so it turns no motor if
    the robot's file has the port of a motor board by mistake.
    """

    def __init__(self, builder: ScanBuilder, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self._builder, self._parser = builder, Parser()
        self._received_at = -math.inf
        self._angles: list[float] = []
        self._distances: list[float] = []
        self._revolution_at = 0.0

    def begin(self, now: float) -> None:
        self.is_ready, self._parser = False, Parser()
        self._drop_revolution()

    def receive(self, data: bytes, now: float) -> None:
        if not (packets := self._parser.feed(data)):
            return
        self.is_ready, self._received_at = True, now
        newest_ms = packets[-1].time_ms
        for packet in packets:
            age_s = (newest_ms - packet.time_ms) % TIME_WRAP_MS / 1000
            if age_s > _MAX_AGE_S:
                self._drop_revolution()
            else:
                self._add(packet, now - age_s)
        if len(data) >= FULL_BUFFER_BYTES:
            self._drop_revolution()

    def data_to_send(self, now: float) -> bytes:
        if self.is_ready and now - self._received_at > _SILENCE_S:
            self.begin(now)
        return b""

    def explain_silence(self, place: str, *, has_received: bool = False) -> str:
        return (_NO_PACKETS if has_received else _SILENT).format(where=f"on {place} at {self.baud} baud")

    def _add(self, packet: Packet, time: float) -> None:
        for angle, millimetres in zip(packet.angles.tolist(), packet.distances, strict=True):
            if self._angles and angle < self._angles[-1] - 180:
                self._builder.add_revolution(np.array(self._angles), np.array(self._distances), self._revolution_at)
                self._drop_revolution()
            if not self._angles:
                self._revolution_at = time
            if len(self._angles) < _MAX_POINTS:
                self._angles.append(angle)
                self._distances.append(millimetres / 1000 if millimetres else math.inf)

    def _drop_revolution(self) -> None:
        self._angles, self._distances = [], []


_MAX_AGE_S = 0.5
"""The largest plausible age of a packet in one read, in seconds: the kernel's buffer holds 0.2 s of data."""

_MAX_POINTS = 4000
"""The largest number of points that are stored for a revolution. A lidar sends 350 to 900 points in one."""

_NO_PACKETS = "the data {where} has no packet of an LD06. Check that this is the lidar's port, and that baud is 230400"
_SILENT = "nothing arrives {where}. Check that the lidar turns, and that its TX goes to the port's RX"

_ANSWER_S = 3.0
"""The longest wait for the first packets, in seconds. The lidar needs time to reach its speed."""

_FIRST_S = 2.0
"""The longest wait for the first scan after the first packets, in seconds."""

_SILENCE_S = 0.4
"""A lidar that is silent for this many seconds is lost."""


class LD06(LidarDriver):
    """Opens lidars that send by themselves. They turn as long as they have power, also after the run."""

    name = "ld06"
    summary = "LD06, LD19: a lidar up to 12 m, on a serial line"
    aliases = ("ld19", "ldrobot", "ldlidar")
    supply = ("5 V", "ground")
    protocol_name = "LD06"
    default_baud = 230400

    def notes(self, description: LidarDescription) -> Sequence[str]:
        return (_POWER,)

    def open(self, description: LidarDescription, context: DeviceContext) -> Lidar:
        builder = ScanBuilder(description)
        line = Line(self.port, LD06Protocol(builder, self.effective_baud), context.clock)
        lidar = SerialLidar(description, builder, line)
        lidar.open(_ANSWER_S, _FIRST_S)
        return lidar


_POWER = (
    "The lidar runs on 5 V, and its TX has 3.3 V: connect it to the port's RX. Connect its PWM line to ground, and it "
    "turns 10 times a second. It turns and its laser is on as long as it has power. Its arrow is the bearing 0."
)

"""Doubles of lidars, which measure the distances that a function returns."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

from drivers.serial.ranging.ld06 import compute_crc
from tests.doubles.serial.board import BoardDouble

Measure = Callable[[float], float]
"""Returns the distance in metres for a bearing in radians, positive to the left; ``inf`` without an echo."""


def build_packet(start: float, step: float, distances: list[float], time_s: float, speed: int = 3600) -> bytes:
    """Return a packet of an LD06. Source: LD06 Development Manual, "Packet format".

    start, step: the angle of the first point and between two points, in degrees, clockwise.
    """
    end = start + step * (len(distances) - 1)
    points = b"".join(
        struct.pack("<HB", 0 if math.isinf(distance) else round(1000 * distance), 200) for distance in distances
    )
    angles = [round(100 * angle) % 36000 for angle in (start, end)]
    head = struct.pack("<BBHH", 0x54, 0x2C, speed, angles[0])
    body = head + points + struct.pack("<HH", angles[1], round(1000 * time_s) % 30000)
    return body + bytes([compute_crc(body)])


class LD06Double(BoardDouble):
    """A double of an LD06 that turns 10 times a second, and sends 375 packets of 12 points a second."""

    STEP, PACKET_S = 0.8, 12 / 4500

    def __init__(self, measure: Measure = lambda _bearing: math.inf) -> None:
        self.measure = measure
        self.change: Callable[[bytes], bytes] = lambda packet: packet
        """Changes each packet that is sent, such as by noise."""
        self._sent = 0

    def receive(self, data: bytes, now: float) -> bytes:
        return b""

    def live(self, now: float, seconds: float) -> bytes:
        sent = b""
        while (self._sent + 1) * self.PACKET_S <= now + 1e-9:
            start = (12 * self._sent * self.STEP) % 360
            distances = [self.measure(-math.radians(start + index * self.STEP)) for index in range(12)]
            sent += self.change(build_packet(start, self.STEP, distances, self._sent * self.PACKET_S))
            self._sent += 1
        return sent


def build_node(angle: float, distance: float, *, is_first: bool) -> bytes:
    """Return a node of an RPLIDAR. Source: RPLIDAR Interface Protocol, "Scan request"."""
    flags = 15 << 2 | (1 if is_first else 2)
    steps, quarters = round(64 * angle) % (360 * 64), 0 if math.isinf(distance) else round(4000 * distance)
    return struct.pack("<BHH", flags, steps << 1 | 1, quarters)


class RPLidarDouble(BoardDouble):
    """A double of an RPLIDAR A1 that turns 5.5 times a second, and sends 2000 nodes a second after the request."""

    NODE_S, TURN_S, START_S = 1 / 2000, 1 / 5.5, 1.0

    def __init__(self, measure: Measure = lambda _bearing: math.inf) -> None:
        self.measure = measure
        self.health = b"\0\0\0"
        self.motor_turns = True
        self.change: Callable[[bytes], bytes] = lambda nodes: nodes
        """Changes the nodes that are sent."""
        self.requests: list[bytes] = []
        self._received, self._sends_at, self._last = b"", math.inf, -1

    @property
    def is_scanning(self) -> bool:
        return self._sends_at < math.inf

    def begin(self, now: float) -> None:
        self._received, self._sends_at = b"", math.inf

    def receive(self, data: bytes, now: float) -> bytes:
        self._received += data
        answer = b""
        while len(self._received) >= 2:
            request, self._received = self._received[:2], self._received[2:]
            self.requests.append(request)
            self._sends_at = math.inf
            if request == b"\xa5\x52":
                answer += bytes.fromhex("a55a0300000006") + self.health
            elif request == b"\xa5\x20" and self.health[0] != 2:
                answer += bytes.fromhex("a55a0500004081")
                self._sends_at, self._last = now + self.START_S, round((now + self.START_S) / self.NODE_S)
        return answer

    def live(self, now: float, seconds: float) -> bytes:
        nodes = b""
        while self.motor_turns and now >= self._sends_at and (self._last + 1) * self.NODE_S <= now + 1e-9:
            self._last += 1
            turns, part = divmod(self._last * self.NODE_S / self.TURN_S, 1.0)
            is_first = turns > ((self._last - 1) * self.NODE_S) // self.TURN_S
            nodes += build_node(360 * part, self.measure(-2 * math.pi * part), is_first=is_first)
        return self.change(nodes) if nodes else b""

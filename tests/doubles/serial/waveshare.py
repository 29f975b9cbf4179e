"""A double of a UGV board with Waveshare's ugv_base_ros of September 2024, with two wheels.

Commands follow uart_ctrl.h and movtion_module.h, feedback follows ugv_advance.h.
"""

from __future__ import annotations

import json
import math
from typing import Any

from tests.doubles.serial.board import BoardDouble, Wheel, Wheels

WHEEL_M = 0.08
"""WHEEL_D of the UGV Rover, in metres."""

PULSES = 660
"""ONE_CIRCLE_PLUSES of the UGV Rover."""

STARTING_S = 2.0
"""The time from a reset until the board's loop starts. A real board takes at least 1.7 s."""

STARTED = b"Initialize LittleFS for Flash files ctrl.\r\nLittleFS mount succeed.\r\nServer Starts.\r\nUGV started.\r\n"


class WaveshareBoard(BoardDouble):
    """The board's loop. The board has its own battery, so unplugging does not reset it."""

    def __init__(self, wheel_m: float = WHEEL_M) -> None:
        self._metres = wheel_m / 2
        self.wheels = Wheels()
        self.centivolts = 1187
        self.received: list[dict[str, Any]] = []
        """All received JSON objects."""
        self.starts_at = -math.inf
        self._waiting, self._is_halted = b"", False
        self._reset_settings(0.0)

    def reset(self, now: float) -> None:
        """Reset the board: its motors stop, and its odometers and settings are cleared."""
        self.wheels = Wheels()
        self.starts_at = now + STARTING_S
        self._reset_settings(now)

    def receive(self, data: bytes, now: float) -> bytes:
        self._waiting += data
        if now < self.starts_at:
            return b""
        *lines, self._waiting = self._waiting.split(b"\n")
        return b"".join(self._receive_line(line, now) for line in lines)

    def live(self, now: float, seconds: float) -> bytes:
        self.wheels.turn(seconds)
        if now < self.starts_at:
            return b""
        started = STARTED if now - seconds < self.starts_at else b""
        if now - self._commanded_at > self.heartbeat_s and not self._is_halted:
            self._is_halted = True
            self._set_speeds(0, 0)
        return started + self._flow(now)

    def _reset_settings(self, now: float) -> None:
        self.heartbeat_s, self.interval_s, self.is_flowing, self.echoes = 3.0, 0.05, True, False
        self.rates = (1.0, 1.0)
        self._commanded_at, self._fed_at, self._is_halted = now, -math.inf, False
        self._waiting = b""

    def _receive_line(self, line: bytes, now: float) -> bytes:
        try:
            received, _ = json.JSONDecoder().raw_decode(line.decode().lstrip())
        except ValueError:
            return b""
        if not isinstance(received, dict):
            return b""
        self.received.append(received)
        self._obey(received, now)
        return line + b"\n" if self.echoes else b""

    def _obey(self, received: dict[str, Any], now: float) -> None:
        match received:
            case {"T": 0}:
                self._set_speeds(0, 0)
            case {"T": 1, "L": float() | int() as left, "R": float() | int() as right}:
                self._is_halted, self._commanded_at = False, now
                self._set_speeds(left, right)
            case {"T": 131, "cmd": flow}:
                self.is_flowing = bool(flow)
            case {"T": 136, "cmd": heartbeat_ms}:
                self.heartbeat_s = heartbeat_ms / 1000
            case {"T": 138, "L": left, "R": right}:
                self.rates = (min(abs(left), 1.0), min(abs(right), 1.0))
            case {"T": 142, "cmd": interval_ms}:
                self.interval_s = abs(interval_ms) / 1000
            case {"T": 143, "cmd": echoes}:
                self.echoes = bool(echoes)

    def _set_speeds(self, left: float, right: float) -> None:
        if abs(left) <= 2 >= abs(right):
            self.wheels.set(*(m_s * rate / self._metres for m_s, rate in zip((left, right), self.rates, strict=True)))

    def _flow(self, now: float) -> bytes:
        if not self.is_flowing or now - self._fed_at < self.interval_s:
            return b""
        self._fed_at = now
        return self.feedback()

    def feedback(self) -> bytes:
        """Return a line of feedback."""
        left, right = self.wheels.left, self.wheels.right
        feedback: dict[str, float] = {"T": 1001, "L": self._speed(left), "R": self._speed(right)}
        feedback |= {"ax": -112, "ay": 48, "gz": 8190, "odl": self._centimetres(left), "odr": self._centimetres(right)}
        feedback |= {"v": self.centivolts}
        return json.dumps(feedback, separators=(",", ":")).encode() + b"\r\n"

    def _speed(self, wheel: Wheel) -> float:
        return round(wheel.velocity * self._metres, 6)

    def _centimetres(self, wheel: Wheel) -> int:
        """Return a wheel's odometer in centimetres, from whole pulses, truncated towards zero."""
        return int(int(wheel.angle / math.tau * PULSES) / PULSES * math.tau * self._metres * 100)

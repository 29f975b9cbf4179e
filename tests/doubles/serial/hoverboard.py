"""A double of a hoverboard with the FOC firmware: its main loop, mixer, filters, time-out and feedback.

Source: Src/main.c and Src/util.c of EFeru/hoverboard-firmware-hack-FOC, variant USART.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from tests.doubles.serial.board import BoardDouble, Wheels

LOOP_S = 0.005
TIMEOUT_LOOPS = 160
ENABLING_S = 0.3
RATE = 480
FILTER = 6553
RPM = math.tau / 60


@dataclass
class Firmware:
    """The settings in config.h. Coefficients are multiplied by 16384. The wheel speed for one unit is in rad/s."""

    speed_coefficient: int = 16384
    steer_coefficient: int = 8192
    is_tank: bool = False
    rad_s_per_unit: float = RPM


class Input:
    """The rate limiter and the low-pass filter of the steer or the speed."""

    def __init__(self) -> None:
        self._limited = self._filtered = 0

    def filter_word(self, word: int) -> int:
        """Return the output of the next main loop."""
        self._limited += max(-RATE, min((word << 4) - self._limited, RATE))
        self._filtered += ((self._limited >> 4 << 4) - (self._filtered >> 12)) * FILTER >> 4
        return self._filtered >> 16


class Hoverboard(BoardDouble):
    """A board with its own battery. Plugging its port in does not reset it."""

    def __init__(self, firmware: Firmware | None = None) -> None:
        self.wheels, self._firmware = Wheels(), firmware or Firmware()
        self.received: list[tuple[int, int]] = []
        self.ignored = 0
        self.is_mute = False
        self._command = (0, 0)
        self._silent_loops = TIMEOUT_LOOPS
        self._inputs = Input(), Input()
        self._loops = 0
        self._next_loop: float | None = None
        self._is_enabled = False

    def receive(self, data: bytes, now: float) -> bytes:
        """Process the bytes between two pauses. The firmware ignores them unless they are a command of eight bytes."""
        if len(data) == 8:
            start, steer, speed, checksum = struct.unpack("<HhhH", data)
            if start == 0xABCD and checksum == (start ^ steer & 0xFFFF ^ speed & 0xFFFF):
                self._command, self._silent_loops = (steer, speed), 0
                self.received.append(self._command)
                return b""
        self.ignored += bool(data)
        return b""

    def live(self, now: float, seconds: float) -> bytes:
        self.wheels.turn(seconds)
        sent = b""
        self._next_loop = now if self._next_loop is None else self._next_loop
        while self._next_loop <= now + 1e-9:
            self._next_loop += LOOP_S
            sent += self._loop()
        return sent

    def _loop(self) -> bytes:
        self._loops += 1
        self._silent_loops += 1
        steer, speed = command = self._command if self._silent_loops <= TIMEOUT_LOOPS else (0, 0)
        if not self._is_enabled and max(map(abs, command)) < 50:
            self._is_enabled = True
            assert self._next_loop is not None
            self._next_loop += ENABLING_S
        self._turn(self._inputs[0].filter_word(steer), self._inputs[1].filter_word(speed))
        return b"" if self._loops % 2 or self.is_mute else self._feedback(steer, speed)

    def _turn(self, steer: int, speed: int) -> None:
        left, right = (steer, speed) if self._firmware.is_tank else self._mix(steer, speed)
        unit = self._firmware.rad_s_per_unit if self._is_enabled else 0.0
        self.wheels.set(left * unit, right * unit)

    def _mix(self, steer: int, speed: int) -> tuple[int, int]:
        along = speed * 16 * self._firmware.speed_coefficient >> 14
        across = steer * 16 * self._firmware.steer_coefficient >> 14
        return _clamp(along + across >> 4), _clamp(along - across >> 4)

    def _feedback(self, steer: int, speed: int) -> bytes:
        left, right = math.floor(self.wheels.left.velocity / RPM), math.floor(-self.wheels.right.velocity / RPM)
        return feedback(steer, speed, right, left, 3796, 300, 0)


def feedback(*words: int) -> bytes:
    """Return the frame of cmd1, cmd2, speedR_meas, speedL_meas, batVoltage, boardTemp and cmdLed."""
    frame = struct.pack("<H7h", 0xABCD, *words)
    checksum = 0
    for (word,) in struct.iter_unpack("<H", frame):
        checksum ^= word
    return frame + struct.pack("<H", checksum)


def _clamp(wheel: int) -> int:
    return max(-1000, min(wheel, 1000))

"""A double of a hoverboard with the FOC firmware: its main loop, time-out and feedback. It has no input filters.

Source: Src/main.c and Src/util.c of EFeru/hoverboard-firmware-hack-FOC, variant USART.
"""

from __future__ import annotations

import math
import struct

from drivers.serial.boards.hoverboard.protocol import Mixer, SteerCommand
from tests.doubles.serial.board import BoardDouble, Wheels

LOOP_S = 0.005
TIMEOUT_LOOPS = 160
ENABLING_S = 0.3
RPM = math.tau / 60


class Hoverboard(BoardDouble):
    """A board with its own battery. Plugging its port in does not reset it."""

    def __init__(self, rad_s_per_unit: float = RPM, *, is_tank: bool = False) -> None:
        self.wheels, self._unit, self._mixer = Wheels(), rad_s_per_unit, Mixer(is_tank=is_tank)
        self.received: list[tuple[int, int]] = []
        self.ignored = 0
        self.is_mute = False
        self._command = (0, 0)
        self._silent_loops = TIMEOUT_LOOPS
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
        unit = self._unit if self._is_enabled else 0.0
        self.wheels.set(*(word * unit for word in self._mixer.wheels(SteerCommand(steer, speed))))
        return b"" if self._loops % 2 or self.is_mute else self._feedback(steer, speed)

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

"""The frames of Sabertooth packet serial, and the protocol of a line with several boards, which never answer.

Source: Dimension Engineering's manuals of the Sabertooth 2x5, 2x12 and 2x25, mode 4, packetized serial.
"""

from __future__ import annotations

import math
from typing import Literal

from drivers.serial.boards.board import CommandBuffer, WheelCommand, describe_timeout
from drivers.serial.protocol import Protocol

MotorNumber = Literal[1, 2]
"""The number of a motor on its board: M1 or M2."""

BAUD_DETECTION = b"\xaa"
"""The first byte on the line, by which a board detects the baud rate. A board ignores this byte afterwards."""

LOWEST_ADDRESS, HIGHEST_ADDRESS = 128, 135
"""The lowest and the highest address that a board's switches can set."""

FULL_DUTY = 127
"""The value of the duty 1 in a frame."""

MAX_TIMEOUT_S = 12.7
"""The longest time-out that a board can have, in seconds."""


def build_packet(address: int, command: int, value: int) -> bytes:
    """Return a frame: the address, a command, its value and a checksum.

    Only the address byte has its top bit set, so that a board detects the beginning of a frame.
    """
    return bytes((address, command, value, address + command + value & 0x7F))


def build_drive_packet(address: int, motor: MotorNumber, duty: float) -> bytes:
    """Return the frame that sets the duty of a motor, from -1 to 1."""
    value = round(duty * FULL_DUTY)
    return build_packet(address, (4 if motor == 2 else 0) + (value < 0), abs(value))


def build_stop_packets(address: int) -> bytes:
    """Return the frames that stop both motors of a board."""
    return build_drive_packet(address, 1, 0.0) + build_drive_packet(address, 2, 0.0)


def round_timeout(seconds: float) -> float:
    """Return a time-out rounded up to tenths of a second, and limited to 0.1 s up to `MAX_TIMEOUT_S`."""
    return max(math.ceil(min(seconds, MAX_TIMEOUT_S) * 10 - 1e-9), 1) / 10


def build_timeout_packet(address: int, seconds: float) -> bytes:
    """Return the frame that sets a board's time-out. Without a command for this time, the board stops its motors.

    After power-on a board has no time-out. The time is rounded by `round_timeout`.
    """
    return build_packet(address, 14, round(round_timeout(seconds) * 10))


SETTLING_S = 0.5
"""The time that a board needs after the first byte to set its baud rate, in seconds."""


class AddressedBoard:
    """One board on the line. M1 is its left motor, and M2 is its right motor."""

    def __init__(self, address: int) -> None:
        self.address = address
        self.command = CommandBuffer()
        self.timeout_s = MAX_TIMEOUT_S

    def build_frames(self, wheels: WheelCommand) -> bytes:
        """Return the frames for both motors and the time-out, which a board loses when it is switched off."""
        motors = build_drive_packet(self.address, 1, wheels.left) + build_drive_packet(self.address, 2, wheels.right)
        return motors + build_timeout_packet(self.address, self.timeout_s)


class SabertoothProtocol(Protocol):
    """Sends the newest command to each board on the line. Stops are sent before other commands.

    No board answers, so the protocol is ready `SETTLING_S` after the first byte. The stops are repeated only while the
    commands of all boards are stops, because any frame on the line may restart the time-out of a turning motor's board.
    """

    def __init__(self, baud: int) -> None:
        self.baud = baud
        self._boards: dict[int, AddressedBoard] = {}
        self._ready_at = -math.inf
        self.is_ready = self._is_new = False

    def board(self, address: int, timeout_s: float) -> AddressedBoard:
        """Return the board with an address. Its time-out is lowered to ``timeout_s`` seconds if it is longer."""
        board = self._boards.get(address) or AddressedBoard(address)
        board.timeout_s = min(board.timeout_s, round_timeout(timeout_s))
        self._boards = {**self._boards, address: board}
        return board

    def begin(self, now: float) -> None:
        self.is_ready = False
        self._is_new = True
        self._ready_at = now + SETTLING_S
        self._clear_commands()

    def receive(self, data: bytes, now: float) -> None:
        """Do nothing: received bytes are an echo or noise, because no board sends data."""

    def data_to_send(self, now: float) -> bytes:
        if self._is_new:
            self._is_new = False
            return BAUD_DETECTION
        if now < self._ready_at:
            return b""
        if not self.is_ready:
            self._clear_commands()
            self.is_ready = True
        return self._command_frames(now) or self._repeat_stops(now)

    def next_due(self, now: float) -> float:
        if now < self._ready_at:
            return now if self._is_new else self._ready_at
        commands = [board.command for board in self._boards.values()]
        again = min((command.repeat_due for command in commands), default=math.inf) if self._is_stopped else math.inf
        return min((again, *(command.next_due for command in commands)))

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent. No board acknowledges commands."""
        return all(board.command.next_due == math.inf for board in self._boards.values())

    @property
    def timeout_notice(self) -> str:
        longest = max((board.timeout_s for board in self._boards.values()), default=MAX_TIMEOUT_S)
        return describe_timeout(longest)

    @property
    def _is_stopped(self) -> bool:
        return all(board.command.newest.is_stop for board in self._boards.values())

    def _command_frames(self, now: float) -> bytes:
        for board in sorted(self._boards.values(), key=lambda board: not board.command.newest.is_stop):
            if (wheels := board.command.take(now, board.timeout_s)) is not None:
                return board.build_frames(wheels)
        return b""

    def _repeat_stops(self, now: float) -> bytes:
        if not self._is_stopped:
            return b""
        again = ((board, board.command.repeat_stop(now)) for board in self._boards.values())
        return b"".join(board.build_frames(wheels) for board, wheels in again if wheels)

    def _clear_commands(self) -> None:
        for board in self._boards.values():
            board.command.clear()

"""Doubles of Sabertooths in packet serial mode, each at its address, on one line. They never answer.

Source: Dimension Engineering's manuals. A board takes the baud rate from the first byte. Its time-out is off at
power-on and restarts with each packet to its address. The next command to a motor ends a stop by the time-out.
"""

from __future__ import annotations

from tests.doubles.serial.board import BoardDouble, Wheels


class Sabertooth:
    """A board whose M1 turns the left wheel, and whose M2 turns the right wheel. The value 127 gives ``full_rad_s``."""

    def __init__(self, wheels: Wheels, full_rad_s: float) -> None:
        self.wheels, self._full_rad_s = wheels, full_rad_s
        self.values = [0, 0]
        self.timeout_s = 0.0
        self._received_at = 0.0

    def obey(self, command: int, value: int, now: float) -> None:
        self._received_at = now
        if command == 14:
            self.timeout_s = value / 10
        elif command in (0, 1, 4, 5):
            self.values[command // 4] = -value if command % 4 else value

    def turn(self, now: float, seconds: float) -> None:
        if self.timeout_s and now - self._received_at > self.timeout_s:
            self.values = [0, 0]
        self.wheels.set(*(value / 127 * self._full_rad_s for value in self.values))
        self.wheels.turn(seconds)


class Sabertooths(BoardDouble):
    """The line with all boards. If its first byte is not that of the baud rate, the boards ignore all bytes."""

    def __init__(self, *, full_rad_s: float = 16.0, addresses: tuple[int, ...] = (128,)) -> None:
        self.boards = {address: Sabertooth(Wheels(), full_rad_s) for address in addresses}
        self.wheels = next((board.wheels for board in self.boards.values()), Wheels())
        self.packets: list[tuple[int, int, int]] = []
        self.ignored = 0
        self._has_rate: bool | None = None
        self._unread = b""

    def receive(self, data: bytes, now: float) -> bytes:
        for byte in data:
            if self._has_rate is None:
                self._has_rate = byte == 0xAA
            elif self._has_rate:
                self._take(byte, now)
        return b""

    def live(self, now: float, seconds: float) -> bytes:
        for board in self.boards.values():
            board.turn(now, seconds)
        return b""

    def _take(self, byte: int, now: float) -> None:
        if byte >= 128:  # an address, at any place
            self.ignored += bool(self._unread)
            self._unread = bytes((byte,)) if byte in self.boards else b""
        elif self._unread:
            self._unread += bytes((byte,))
        if len(self._unread) == 4:
            address, command, value, checksum = self._unread
            self._unread = b""
            if checksum == sum((address, command, value)) % 128:
                self.packets.append((address, command, value))
                self.boards[address].obey(command, value, now)
            else:
                self.ignored += 1

"""The base class of the protocols of motor boards, and the opening of a board that several devices share."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar, Generic, TypeVar

from drivers.serial.boards.command import CommandBuffer
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.driver import PortSettings, Side
from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from robotcore.errors import DeviceError
from robotcore.hal.devices import Voltage
from robotcore.hardware import Host


class BoardProtocol(Protocol):
    """The base class of the protocols of boards that send data, on request or periodically.

    A board that has sent nothing for longer than `silence_s` is lost. The protocol drops the command when the board is
    lost, and again when the board sends data again. So a command that was set during the loss never turns a wheel.
    """

    default_timeout_s: ClassVar[float]
    """The board stops its motors after this many seconds without a command, unless `limit` sets a shorter time."""

    counters: Mapping[Side, CountAccumulator]
    """The counters of both wheels."""

    voltage: Voltage | None = None
    """The newest voltage of the battery; None before the first one."""

    def __init__(self, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self.command = CommandBuffer()
        self._timeouts_s: list[float] = []
        self._received_at = -math.inf

    @property
    @abstractmethod
    def silence_s(self) -> float:
        """The longest pause, in seconds, between two messages from a connected board."""

    def limit(self, timeout_s: float) -> None:
        """Lower the board's time-out to ``timeout_s`` seconds if it is longer. A fixed time-out does not change."""
        self._timeouts_s.append(timeout_s)

    @property
    def timeout_s(self) -> float:
        """The time without a command, in seconds, after which the board stops its motors."""
        return min(self._timeouts_s, default=self.default_timeout_s)

    @property
    def timeout_notice(self) -> str:
        return describe_timeout(self.timeout_s)

    @property
    def is_settled(self) -> bool:
        """Whether the newest command was sent."""
        return math.isinf(self.command.next_due)

    def begin(self, now: float) -> None:
        self._received_at = -math.inf
        self._lose(now)

    def _lose_if_silent(self, now: float) -> None:
        if self.is_ready and now - self._received_at > self.silence_s:
            self._lose(now)

    def _lose(self, now: float) -> None:
        self.is_ready = False
        self.command.clear()

    def _set_ready(self) -> None:
        self.command.clear()  # no motor turns before a new command
        self.is_ready = True

    def _set_voltage(self, volts: float, now: float) -> None:
        self.voltage = Voltage(volts, now, self.voltage.sequence + 1 if self.voltage else 0)


def describe_timeout(timeout_s: float) -> str:
    """Return the sentence for error messages, without full stop, that describes the time-out of a board."""
    return f"The board stops its motors by itself {timeout_s:g} s after the last command that it received"


ProtocolT_co = TypeVar("ProtocolT_co", bound=Protocol, covariant=True)
ProtocolT = TypeVar("ProtocolT", bound=Protocol)


class Board(Generic[ProtocolT_co]):
    """A board that several devices share."""

    def __init__(self, opener: str, line: Line, protocol: ProtocolT_co) -> None:
        self.opener, self.line, self.protocol = opener, line, protocol
        self.failure: DeviceError | None = None
        """The error of opening the board, so that its other devices fail without a second wait."""

    def close(self) -> None:
        self.line.close()


class SharedBoardError(DeviceError):
    """A device cannot be opened, because opening its board already failed for another device.

    The DeviceError of that other device has the reason.
    """

    kind = "shared-board"


def open_board(
    device: str, settings: PortSettings, make: Callable[[int], ProtocolT], host: Host, answer_s: float
) -> Board[ProtocolT]:
    """Return the board on a port; open the port if this device is the first one of the board.

    If the board cannot be opened, the first device gets a DeviceError with the reason. All other devices of the board
    get a SharedBoardError.

    device: the name of the device, for errors.
    make: the class of the board's protocol, whose argument is the speed of the line in baud.
    answer_s: the longest wait for the board's first data, in seconds.
    """

    def open_once() -> Board[ProtocolT]:
        protocol = make(settings.speed)
        board = Board(device, Line(settings.port, protocol, host.clock), protocol)
        try:
            board.line.open(device, answer_s)
        except DeviceError as failure:
            board.failure = failure
        return board

    board: Board[ProtocolT] = host.shared.take(Board, (make, settings.port), open_once)
    if board.failure and board.opener == device:
        raise board.failure
    if board.failure:
        raise SharedBoardError(
            device, f"its board on {settings.port} could not be opened; see the error of {board.opener}"
        )
    return board

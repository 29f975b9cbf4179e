"""The base classes of the drivers of a board's motors, encoders and battery."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

from pydantic import Field, model_validator

from drivers.serial.boards.devices import BoardBattery, BoardEncoder, BoardOutput
from drivers.serial.driver import SerialDriver, Side
from drivers.serial.line import Line
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError, Mistake
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hardware import DeviceContext
from robotcore.kinds.battery import Battery, BatteryDescription
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.motor import MotorDescription

BoardTimeout = Annotated[float, Field(ge=0.1, le=5)]
"""The type of a key ``board_timeout_s``: the board stops its motors after this many seconds without a command."""


class Board:
    """A board that several devices share."""

    def __init__(self, opener: str, line: Line, protocol: Any) -> None:
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


class BoardDriver(SerialDriver):
    """The base class of the drivers of a board's devices. The class attributes are the same for all its drivers."""

    protocol: ClassVar[type[Any]]
    """The class of the board's protocol, a `Protocol` whose argument is the speed of the line in baud."""
    answer_s: ClassVar[float]
    """The longest wait for the board's first data, in seconds."""
    first_s: ClassVar[float] = 1.0
    """The longest wait for the first sample of a device after the first data of its board, in seconds."""
    stop: ClassVar[bytes]
    """The frame that stops both motors of the board, for the guardian and `robotcore stop`."""
    standing: ClassVar[str]
    """A regular expression for the board's answer to ``stop``."""

    def open_board(self, device: str, context: DeviceContext) -> Board:
        """Return the board on the port; open the port if this device is the first one of the board.

        If the board cannot be opened, the first device gets a DeviceError with the reason. All other devices of the
        board get a SharedBoardError.

        device: the name of the device, for errors.
        """

        def open_once() -> Board:
            protocol = self.protocol(self.effective_baud)
            board = Board(device, Line(self.port, protocol, context.clock), protocol)
            try:
                board.line.open(device, self.answer_s)
            except DeviceError as failure:
                board.failure = failure
            return board

        board = context.shared.take(Board, (self.protocol, self.port), open_once)
        if board.failure and board.opener == device:
            raise board.failure
        if board.failure:
            problem = f"its board on {self.port} could not be opened; see the error of {board.opener}"
            raise SharedBoardError(device, problem)
        return board

    def stop_frame(self, device: str, frame: bytes, answer: str | None, context: DeviceContext) -> CutoffSpec:
        """Return the specification of a `StopFrame`, for the guardian and for `robotcore stop`.

        Both merge the equal cutoffs of several devices on one port, so they send the frame of a board only once.

        answer: a regular expression for the board's answer; None if the board never answers.
        """
        parameters = {
            "place": self.port,
            "baud": self.effective_baud,
            "frame": frame.hex(),
            "answer": answer,
            "has_owner": context.owner is not None,
        }
        return CutoffSpec(device, "drivers.serial.boards.cutoff:StopFrame", parameters)


class MotorDriver(BoardDriver):
    """The base class of the drivers of a board's motors."""

    described = MotorDescription
    side: Side
    trim: Annotated[float, Field(ge=0.8, le=1.25)] = 1.0
    """The factor on each velocity that is sent to the board, if its wheel turns too slowly or too fast.

    `robotcore calibrate motors` measures it. A motor with a model has none.
    """

    @model_validator(mode="after")
    def _refuse_trim_with_model(self) -> MotorDriver:
        if self.trim != 1 and getattr(self, "model", None):
            problem = f"trim is {self.trim:g}, but the motor has a model"
            raise Mistake(problem, "Remove trim, and correct the model", kind="trim-with-model")
        return self

    @property
    def part(self) -> str:
        return f"{self.side} motor"

    def open_output(self, device: str, context: DeviceContext, unit: float = 1.0) -> BoardOutput:
        """Return the output to the motor; raises DeviceError if the board cannot be opened.

        unit: the board's command value for 1, which is a duty, or a velocity in rad/s.
        """
        board = self.open_board(device, context)
        return BoardOutput(device, board.line, board.protocol.command, self.side, self.trim * unit)

    def cutoffs(self, description: MotorDescription, context: DeviceContext) -> Sequence[CutoffSpec]:
        return (self.stop_frame(description.name, self.stop, self.standing, context),)


class EncoderDriver(BoardDriver):
    """The base class of the drivers of a board's encoders."""

    described = EncoderDescription
    side: Side

    @property
    def part(self) -> str:
        return f"{self.side} encoder"

    @abstractmethod
    def rad_per_unit(self, description: EncoderDescription, robot: RobotDescription) -> float:
        """Return the wheel's angle in rad for one unit of the board's counter."""

    def open(self, description: EncoderDescription, context: DeviceContext) -> Encoder:
        board = self.open_board(description.name, context)
        counter, unit = board.protocol.counters[self.side], self.rad_per_unit(description, context.robot)
        return BoardEncoder(description.name, board.line, lambda: counter.angle(unit), self.first_s)


class BatteryDriver(BoardDriver):
    """The base class of the drivers of a board's battery."""

    described = BatteryDescription

    @property
    def part(self) -> str:
        return "battery"

    def open(self, description: BatteryDescription, context: DeviceContext) -> Battery:
        board = self.open_board(description.name, context)
        return BoardBattery(description.name, board.line, lambda: board.protocol.voltage, self.first_s)

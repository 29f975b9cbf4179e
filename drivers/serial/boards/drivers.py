"""The base classes of the drivers of a board's motors, encoders and battery."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, TypeVar

from drivers.serial.boards.board import Board, open_board
from drivers.serial.boards.cutoff import stop_frame
from drivers.serial.boards.devices import BoardBattery, BoardEncoder, BoardOutput
from drivers.serial.driver import DescriptionT, SerialDriver, SettingsT, SideSettings
from robotcore.description import BatteryDescription, EncoderDescription, MotorDescription, RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Battery, Encoder
from robotcore.hardware import Host

SideSettingsT = TypeVar("SideSettingsT", bound=SideSettings)


class BoardDriver(SerialDriver[DescriptionT, SettingsT]):
    """The base class of the drivers of a board's devices. The attributes are the same for all drivers of a board."""

    protocol: ClassVar[type[Any]]
    """The class of the board's protocol, a `BoardProtocol` whose argument is the speed of the line in baud."""
    answer_s: ClassVar[float]
    """The longest wait for the board's first data, in seconds."""
    first_s: ClassVar[float] = 1.0
    """The longest wait for the first sample of a device after the first data of its board, in seconds."""
    stop: ClassVar[bytes]
    """The frame that stops both motors of the board, for the guardian and `robotcore stop`."""
    standing: ClassVar[str]
    """A regular expression for the board's answer to ``stop``."""

    def open_board(self, device: str, settings: SettingsT, host: Host) -> Board[Any]:
        """Return the board of a device; raises DeviceError if it cannot be opened."""
        return open_board(device, settings, self.protocol, host, self.answer_s)


class MotorDriver(BoardDriver[MotorDescription, SideSettingsT]):
    """The base class of the drivers of a board's motors."""

    described = MotorDescription
    part = "motor"

    def open_output(
        self, description: MotorDescription, settings: SideSettingsT, host: Host, unit: float = 1.0
    ) -> BoardOutput:
        """Return the output to the motor; raises DeviceError if the board cannot be opened.

        unit: the board's command value for 1, which is a duty, or a velocity in rad/s.
        """
        board = self.open_board(description.name, settings, host)
        return BoardOutput(description.name, board.line, board.protocol.command, settings.side, unit)

    def cutoffs(self, description: MotorDescription, settings: SideSettingsT, host: Host) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings, self.stop, self.standing, host),)


class EncoderDriver(BoardDriver[EncoderDescription, SideSettingsT]):
    """The base class of the drivers of a board's encoders."""

    described = EncoderDescription
    part = "encoder"

    @abstractmethod
    def rad_per_unit(self, description: EncoderDescription, settings: SideSettingsT, robot: RobotDescription) -> float:
        """Return the wheel's angle in rad for one unit of the board's counter."""

    def open(self, description: EncoderDescription, settings: SideSettingsT, host: Host) -> Encoder:
        board = self.open_board(description.name, settings, host)
        counter, unit = board.protocol.counters[settings.side], self.rad_per_unit(description, settings, host.robot)
        return BoardEncoder(description.name, board.line, lambda: counter.angle(unit), self.first_s)


class BatteryDriver(BoardDriver[BatteryDescription, SettingsT]):
    """The base class of the drivers of a board's battery."""

    described = BatteryDescription
    part = "battery"

    def open(self, description: BatteryDescription, settings: SettingsT, host: Host) -> Battery:
        board = self.open_board(description.name, settings, host)
        return BoardBattery(description.name, board.line, lambda: board.protocol.voltage, self.first_s)

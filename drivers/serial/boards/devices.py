"""The motors, encoders and batteries of a motor board."""

from __future__ import annotations

from collections.abc import Callable

from drivers.serial.boards.board import CommandBuffer
from drivers.serial.driver import Side
from drivers.serial.line import Line
from robotcore.hal.device import SampleT, Sensor
from robotcore.hardware.motor_model import Output
from robotcore.kinds.battery import Battery, Voltage
from robotcore.kinds.encoder import Angle, Encoder


class BoardOutput(Output):
    """Sends commands to one motor of a board.

    unit: the board's command value for 1, which is a duty, or a velocity in rad/s.
    """

    def __init__(self, device: str, line: Line, command: CommandBuffer, side: Side, unit: float = 1.0) -> None:
        self._device, self._line, self._command, self._side, self._unit = device, line, command, side, unit

    def turn(self, duty: float) -> None:
        """Set the command of the motor, a duty or a velocity in rad/s; raises DeviceLostError if the line is lost."""
        self._line.require(self._device)
        self._command.set(self._side, duty * self._unit, self._line.now())
        self._line.wake()

    def close(self) -> None:
        """Wait until the last command is sent, and is acknowledged if the board acknowledges commands.

        Raises DeviceError after `drivers.serial.line.CLOSING_S`.
        """
        self._line.settle(self._device)


class BoardSensor(Sensor[SampleT]):
    """A sensor of a board. The thread of the line receives its samples.

    After a loss of the line, reading raises DeviceLostError until a new sample arrives.
    """

    def __init__(self, name: str, line: Line, read_latest: Callable[[], SampleT | None], first_s: float) -> None:
        """Create the sensor, and wait for its first sample; raises DeviceError if there is none.

        read_latest: returns the newest sample; None before the first one.
        first_s: the longest wait in seconds.
        """
        super().__init__(name)
        self._line, self._read_latest = line, read_latest
        problem = f"the board on {line.place} has not sent a value of this device"
        line.wait_until(lambda: read_latest() is not None, name, first_s, lambda: problem)

    def _newest(self) -> SampleT:
        self._line.require(self.name)
        sample = self._read_latest()
        assert sample, "the constructor has waited for the first sample"
        self._line.require_since_lost(self.name, sample.time)
        return sample


class BoardEncoder(BoardSensor[Angle], Encoder):
    """An encoder on a board."""


class BoardBattery(BoardSensor[Voltage], Battery):
    """A battery whose voltage a board measures."""

"""The motors, encoders and batteries of a motor board."""

from __future__ import annotations

from collections.abc import Callable

from drivers.serial.boards.command import CommandBuffer
from drivers.serial.driver import Side
from drivers.serial.line import Line
from robotcore.description import MotorDescription
from robotcore.hal.devices import Angle, Battery, Encoder, Motor, SampleT, Sensor, Voltage
from robotcore.hardware.motor_model import Output


class CountAccumulator:
    """Adds up the changes of one wheel's counter, in the board's own unit.

    After `restart`, the next count is the new reference, and the total does not change. The line's thread calls `add`,
    and the app's threads call `angle`.
    """

    def __init__(self, wraps_at: float | None = None) -> None:
        """Create an accumulator without a count.

        wraps_at: the number of counts after which the board's counter wraps around, 2³² for 32 bits; None if never.
        """
        self._wraps_at = wraps_at
        self._last: float | None = None
        self._newest: tuple[float, float, int] | None = None

    def add(self, count: float, time: float) -> None:
        """Add the change since the last count to the total.

        count: the value of the board's counter.
        time: the time of arrival of the count, in seconds.
        """
        total, _, sequence = self._newest or (0.0, 0.0, -1)
        total += self._difference(count)
        self._last = count
        self._newest = total, time, sequence + 1

    def restart(self) -> None:
        """Drop the last count after a reset of the board. The total does not change."""
        self._last = None

    def angle(self, rad_per_unit: float) -> Angle | None:
        """Return the angle of the wheel at the newest count; None before the first count."""
        if self._newest is None:
            return None
        total, time, sequence = self._newest
        return Angle(total * rad_per_unit, time, sequence)

    def _difference(self, count: float) -> float:
        if self._last is None:
            return 0.0
        return wrap_difference(count - self._last, self._wraps_at) if self._wraps_at else count - self._last


def wrap_difference(difference: float, wraps_at: float) -> float:
    """Return the difference of two values of a counter that wraps around at ``wraps_at``, from the shorter way."""
    return (difference + wraps_at / 2) % wraps_at - wraps_at / 2


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


class BoardMotor(Motor):
    """A motor whose velocity its board controls. Its output takes velocities in rad/s."""

    def __init__(self, description: MotorDescription, output: BoardOutput) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._output = output

    def _apply(self, rad_s: float) -> None:
        self._output.turn(rad_s)

    def _release(self) -> None:
        self._output.close()


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

"""The motors, encoders and batteries of a motor board."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic

from drivers.serial.boards.command import CommandBuffer
from drivers.serial.driver import Side
from drivers.serial.line import Line
from robotcore.description import MotorDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Angle, Battery, Encoder, Motor, SampleT, Sensor, Voltage
from robotcore.hardware.motor_model import Output


class CountAccumulator:
    """Adds up the changes of one wheel's counter, in the board's own unit.

    After `restart`, the next count is the new reference, and the total does not change. The line's thread calls `add`,
    and the app's threads call `angle`.

    >>> counter = CountAccumulator(wraps_at=2**32)
    >>> for time, count in enumerate((2**31 - 1, -(2**31) + 1)):
    ...     counter.add(count, time)
    >>> counter.angle(rad_per_unit=0.5)
    Angle(angle=1.0, time=1, sequence=1)
    """

    def __init__(self, wraps_at: float | None = None) -> None:
        """Create an accumulator without a count.

        wraps_at: the number of counts after which the board's counter wraps around, 2³² for 32 bits; None if never.
        """
        self._wraps_at = wraps_at
        self._last: float | None = None
        self._newest: tuple[float, float, int] | None = None

    def __repr__(self) -> str:
        total, time, sequence = self._newest or (0.0, -math.inf, -1)
        return f"CountAccumulator(total={total:g}, time={time:g}, sequence={sequence})"

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
        turned = count - self._last
        if self._wraps_at:
            turned = (turned + self._wraps_at / 2) % self._wraps_at - self._wraps_at / 2
        return turned


class BoardOutput(Output):
    """Sends commands to one motor of a board, in the board's own unit."""

    def __init__(self, device: str, line: Line, command: CommandBuffer, side: Side) -> None:
        self._device, self._line, self._command, self._side = device, line, command, side

    def turn(self, duty: float) -> None:
        """Set the command of the motor; raises DeviceLostError if the line is lost.

        duty: the value in the unit of the board's commands; a duty only if the board takes duties.
        """
        self._line.require(self._device)
        self._command.set(self._side, duty, self._line.now())
        self._line.wake()

    def close(self) -> None:
        """Wait until the last command is sent, and is acknowledged if the board acknowledges commands.

        Raises DeviceError after `drivers.serial.line.CLOSING_S`.
        """
        self._line.settle(self._device)


class BoardMotor(Motor):
    """A motor whose velocity its board controls."""

    def __init__(self, description: MotorDescription, output: BoardOutput, unit_per_rad_s: float) -> None:
        """Create the motor.

        unit_per_rad_s: the board's command value for 1 rad/s.
        """
        super().__init__(description.name, description.max_velocity_rad_s)
        self._output, self._unit_per_rad_s = output, unit_per_rad_s

    def _apply(self, rad_s: float) -> None:
        self._output.turn(rad_s * self._unit_per_rad_s)

    def _release(self) -> None:
        self._output.close()


class BoardSensor(Sensor[SampleT], Generic[SampleT]):
    """A sensor of a board. The thread of the line receives its samples.

    After a loss of the line, reading raises DeviceLostError until a new sample arrives.
    """

    def __init__(self, name: str, line: Line, read_latest: Callable[[], SampleT | None]) -> None:
        """Create the sensor.

        read_latest: returns the newest sample; None before the first one.
        """
        super().__init__(name)
        self._line, self._read_latest = line, read_latest

    def await_first(self, within_s: float) -> None:
        """Wait up to ``within_s`` seconds for the first sample; raises DeviceError if there is none."""
        self._line.wait_until(lambda: self._read_latest() is not None, self.name, within_s, self._no_sample_yet)

    def _newest(self) -> SampleT:
        self._line.require(self.name)
        if (sample := self._read_latest()) is None:
            raise DeviceError(self.name, self._no_sample_yet, kind="no-sample-yet")
        self._line.require_since_lost(self.name, sample.time)
        return sample

    @property
    def _no_sample_yet(self) -> str:
        return f"the board on {self._line.place} has not sent a value of this device"


class BoardEncoder(BoardSensor[Angle], Encoder):
    """An encoder on a board. ``rad_per_unit`` is the wheel's angle in rad for one unit of the board's counter."""

    def __init__(self, name: str, line: Line, counter: CountAccumulator, rad_per_unit: float) -> None:
        super().__init__(name, line, lambda: counter.angle(rad_per_unit))


class BoardBattery(BoardSensor[Voltage], Battery):
    """A battery whose voltage a board measures."""

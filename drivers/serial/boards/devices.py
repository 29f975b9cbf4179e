"""The devices of a motor board: they pass on commands and read the newest values from the board."""

from __future__ import annotations

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
    """Adds up what a board counts of one wheel, in the board's own unit, from the first count on.

    After `restart` the next count is taken to be where the last one was: what the wheel turned meanwhile nobody knows,
    and nothing is made up for it. ``wraps_at`` is how many counts the board's counter has before it begins anew, 2³²
    for a 32-bit one. One thread counts, others ask for the angle.

    >>> turning = CountAccumulator(wraps_at=2**32)
    >>> for time, count in enumerate((2**31 - 1, -(2**31) + 1)):
    ...     turning.count(count, time)
    >>> turning.angle(rad_per_unit=0.5)
    Angle(angle=1.0, time=1, sequence=1)
    """

    def __init__(self, wraps_at: float | None = None) -> None:
        self._wraps_at = wraps_at
        self._last: float | None = None
        self._newest: tuple[float, float, int] | None = None

    def count(self, counted: float, time: float) -> None:
        """Take what the board's counter is at ``time``, when its frame came in."""
        total, _, sequence = self._newest or (0.0, 0.0, -1)
        total += self._turned(counted)
        self._last = counted
        self._newest = total, time, sequence + 1

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self._last = None

    def angle(self, rad_per_unit: float) -> Angle | None:
        """Return the wheel's angle, as old as the newest count; None where there was none."""
        if self._newest is None:
            return None
        total, time, sequence = self._newest
        return Angle(total * rad_per_unit, time, sequence)

    def _turned(self, counted: float) -> float:
        if self._last is None:
            return 0.0
        turned = counted - self._last
        if self._wraps_at:
            turned = (turned + self._wraps_at / 2) % self._wraps_at - self._wraps_at / 2
        return turned


class BoardOutput(Output):
    """One side of a board: what a motor sends goes there, in the unit of the board's `CommandBuffer`.

    As it is, for a `DutyMotor`, it takes duties.
    """

    def __init__(self, device: str, line: Line, command: CommandBuffer, side: Side) -> None:
        self._device, self._line, self._command, self._side = device, line, command, side

    def turn(self, duty: float) -> None:
        """Have it sent; raises DeviceLostError, by the motor's name, where the line is lost."""
        self._line.require(self._device)
        self._command.set(self._side, duty, self._line.now())
        self._line.wake()

    def close(self) -> None:
        """Wait until the board has heard the last command; raises DeviceError where that cannot be told."""
        self._line.settle(self._device)


class BoardMotor(Motor):
    """A motor whose velocity its board holds; ``unit_per_rad_s`` is what the board is told for 1 rad/s."""

    def __init__(self, description: MotorDescription, output: BoardOutput, unit_per_rad_s: float) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._output, self._unit_per_rad_s = output, unit_per_rad_s

    def _apply(self, rad_s: float) -> None:
        self._output.turn(rad_s * self._unit_per_rad_s)

    def _release(self) -> None:
        self._output.close()


class BoardSensor(Sensor[SampleT], Generic[SampleT]):
    """Something that a board tells of by itself or is asked for all the time; ``set`` returns what it told last.

    None is that it has not told anything yet. While the line is lost it is read no more, nor is what was told before.
    """

    def __init__(self, name: str, line: Line, read_latest: Callable[[], SampleT | None]) -> None:
        super().__init__(name)
        self._line, self._read_latest = line, read_latest

    def await_first(self, within_s: float) -> None:
        """Wait until there is a first sample; raises DeviceError where there is none in this time."""
        self._line.wait_until(lambda: self._read_latest() is not None, self.name, within_s, self._no_sample_yet)

    def _newest(self) -> SampleT:
        self._line.require(self.name)
        if (sample := self._read_latest()) is None:
            raise DeviceError(self.name, self._no_sample_yet, kind="no-sample-yet")
        self._line.require_since_lost(self.name, sample.time)
        return sample

    @property
    def _no_sample_yet(self) -> str:
        return f"the board on {self._line.place} has not told anything of it"


class BoardEncoder(BoardSensor[Angle], Encoder):
    """A wheel whose turns a board counts; ``rad_per_unit`` is the angle of one of the board's counts."""

    def __init__(self, name: str, line: Line, turning: CountAccumulator, rad_per_unit: float) -> None:
        super().__init__(name, line, lambda: turning.angle(rad_per_unit))


class BoardBattery(BoardSensor[Voltage], Battery):
    """A battery whose voltage a board measures."""

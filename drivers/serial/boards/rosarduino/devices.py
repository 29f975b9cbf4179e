"""The devices of an Arduino, and the conversion of replies to samples."""

from __future__ import annotations

import math

from drivers.serial.boards.devices import BoardMotor, BoardOutput, BoardSensor, CountAccumulator
from drivers.serial.boards.rosarduino.protocol import Reply
from drivers.serial.line import Line
from robotcore.description import MotorDescription, RangeSensorDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Range, RangeSensor, Voltage
from robotcore.hardware.polled_samples import RangeSampler

FASTEST_HZ = 50_000
"""The most encoder edges that an Arduino can count in a second."""

MISSED_S = 0.05
"""A pause between two counts that is longer than this many seconds: a reply was lost, or the board was reset."""

WRAPS_AT = 2**32
"""The number of counts after which the board's 32-bit counter wraps around."""

SAME_MEASUREMENT_S = 0.02
"""Two ranges belong to one measurement if their times differ by less than this many seconds. robotcore_bridge measures
every 0.06 s."""

MUTE_S = 0.5
"""An ultrasonic module that has not answered its trigger for this many seconds has failed."""

MUTE_PINGS = 3
"""After this many requests in a row without a pulse, an ultrasonic module of ROSArduinoBridge has failed. Each such
request takes a second."""

_MUTE = "the board's ultrasonic module does not answer its trigger; check its 5 V, its ground and its pins"

NOT_WIRED = (
    "the board's firmware was built without a battery; set BATTERY_PIN in config.h to the pin of its divider, and "
    "flash it again"
)


class Counts:
    """Adds up the counts of a wheel's encoder, and ignores impossible counts.

    A count that is too far from the last one is ignored, unless the next count confirms it. A reset sets the board's
    counter to zero. So after a pause, a count that is nearer to zero than to the last count shows a reset. Turns
    during a reset are lost.
    """

    def __init__(self) -> None:
        self.counter = CountAccumulator(WRAPS_AT)
        """The sum of the wheel's counts."""
        self._last: tuple[int, float] | None = None
        self._doubted: tuple[int, float] | None = None

    def take(self, count: int, time: float) -> None:
        """Process a count that arrived at ``time``, in seconds. An impossible count is ignored."""
        if self._last and _was_reset(count, time, *self._last):
            self.restart()
        elif self._last and not _follows(count, time, *self._last):
            if not (self._doubted and _follows(count, time, *self._doubted)):
                self._doubted = count, time
                return
            self.restart()
        self._last, self._doubted = (count, time), None
        self.counter.add(count, time)

    def restart(self) -> None:
        """Drop the last count after a reset of the board. The sum stays."""
        self._last = self._doubted = None
        self.counter.restart()


def _was_reset(count: int, time: float, before: int, then: float) -> bool:
    return time - then > MISSED_S and abs(count) < abs(_difference(count, before))


def _follows(count: int, time: float, before: int, then: float) -> bool:
    return abs(_difference(count, before)) <= math.ceil((time - then) * FASTEST_HZ)


def _difference(count: int, before: int) -> int:
    return (count - before + WRAPS_AT // 2) % WRAPS_AT - WRAPS_AT // 2


class Ranges:
    """Converts the replies of robotcore_bridge to samples.

    A reply has the newest range in mm, or -1 without an echo, and the age of the range in ms.
    """

    def __init__(self, device: str, sampler: RangeSampler) -> None:
        self._device, self._sampler = device, sampler
        self._last: float | None = None

    def take(self, reply: Reply, now: float) -> None:
        """Convert a reply that arrived at ``now``, in seconds, to a sample."""
        if reply.is_refusal:
            return
        millimetres, age_ms = reply.numbers
        time = now - age_ms / 1000
        if age_ms > MUTE_S * 1000:
            self._sampler.fail(DeviceError(self._device, _MUTE, kind="module-silent"))
        elif self._last is None or time - self._last > SAME_MEASUREMENT_S:
            self._last = time
            self._add(millimetres, time)

    def _add(self, millimetres: int, time: float) -> None:
        if millimetres < 0:
            self._sampler.clear_failure()
            self._sampler.add_no_echo(time)
        else:
            self._sampler.add_distance(millimetres / 1000, time)


class Pings:
    """Converts the replies of ROSArduinoBridge to samples. A reply has a range in cm, or 0 without a pulse.

    If no echo returns, the module ends its pulse after its own time-out, which gives a range beyond the maximum. So
    such a range means a far target or no echo.
    """

    def __init__(self, description: RangeSensorDescription, sampler: RangeSampler) -> None:
        self._description, self._sampler = description, sampler
        self._silent_pings = 0

    def take(self, reply: Reply, now: float) -> None:
        """Convert a reply that arrived at ``now``, in seconds, to a sample."""
        if reply.is_refusal:
            return
        distance = reply.numbers[0] / 100
        self._silent_pings = 0 if distance else self._silent_pings + 1
        if self._silent_pings >= MUTE_PINGS:
            self._sampler.fail(DeviceError(self._description.name, _MUTE, kind="module-silent"))
        elif not distance:
            self._sampler.add_unclear()
        elif distance > self._description.max_range_m:
            self._sampler.clear_failure()
            self._sampler.add_no_echo(now)
        else:
            self._sampler.add_distance(distance, now)


class Voltages:
    """Stores the newest voltage that the board has measured."""

    def __init__(self, device: str) -> None:
        self._device = device
        self._newest: Voltage | None = None
        self._is_wired = True

    def take(self, reply: Reply, now: float) -> None:
        """Store the voltage in a reply. It is in mV, and negative if no battery is connected."""
        if reply.is_refusal:
            return
        millivolts = reply.numbers[0]
        self._is_wired = millivolts >= 0
        if self._is_wired:
            self._newest = Voltage(millivolts / 1000, now, self._newest.sequence + 1 if self._newest else 0)

    def newest(self) -> Voltage | None:
        """Return the newest voltage; None before the first one. Raises DeviceError if no battery is connected."""
        if not self._is_wired:
            raise DeviceError(self._device, NOT_WIRED, kind="battery-not-wired")
        return self._newest


class CountingMotor(BoardMotor):
    """A motor on a board that accepts only whole counts per control period.

    `set_velocity` rounds to the nearest velocity of whole counts. Less than half a count per control period becomes 0.
    ``max_velocity`` is a whole number of counts per control period too.
    """

    def __init__(self, description: MotorDescription, output: BoardOutput, counts_per_rad_s: float) -> None:
        """Create the motor.

        counts_per_rad_s: the number of counts in a control period at 1 rad/s.
        """
        super().__init__(description, output, counts_per_rad_s)
        self._counts_per_rad_s = counts_per_rad_s
        self.max_velocity = math.floor(description.max_velocity_rad_s * counts_per_rad_s) / counts_per_rad_s

    def set_velocity(self, rad_s: float) -> float:
        return round(super().set_velocity(rad_s) * self._counts_per_rad_s) / self._counts_per_rad_s

    def _apply(self, rad_s: float) -> None:
        super()._apply(round(rad_s * self._counts_per_rad_s) / self._counts_per_rad_s)


class Sonar(BoardSensor[Range], RangeSensor):
    """The ultrasonic module of a board. Reading it raises DeviceLostError while the line is lost."""

    def __init__(self, description: RangeSensorDescription, line: Line, sampler: RangeSampler) -> None:
        RangeSensor.__init__(
            self,
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._line, self._sampler = line, sampler

    def await_first(self, within_s: float) -> None:
        self._line.wait_until(lambda: self._sampler.has_result, self.name, within_s, self._no_sample_yet)
        self._newest()

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = self._sampler.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest

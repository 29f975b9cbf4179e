"""The devices that this board adds, and how its answers become their samples."""

from __future__ import annotations

import math

from drivers.serial.boards.devices import BoardMotor, BoardOutput, BoardSensor, CountAccumulator
from drivers.serial.boards.rosarduino.protocol import Answer
from drivers.serial.line import Line
from robotcore.description import MotorDescription, RangeSensorDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Range, RangeSensor, Voltage
from robotcore.hardware.polled import RangeSampler

FASTEST_HZ = 50_000
"""No such board counts more edges in a second."""

MISSED_S = 0.05
"""After a pause of so long an answer was lost: a board that was reset takes longer to begin anew."""

WRAPS_AT = 2**32
"""A count has 32 bits."""

SAME_S = 0.02
"""Ranges whose times are no farther apart are one: our firmware's cycle is 0.06 s, and it tells ages in ms."""

MUTE_S = 0.5
"""A module that has not answered a trigger for so long does not work."""

MUTE_PINGS = 3
"""So many questions in a row without a pulse, a second each, are a fault."""

_MUTE = "the board's ultrasonic module does not answer its trigger; look at its 5 V, its ground and its pins"

NOT_WIRED = (
    "the board's firmware was built without a battery; name the pin of its divider, BATTERY_PIN in config.h, and flash "
    "it again"
)


class Counts:
    """Adds up a wheel's counts, but for those that it cannot have come to.

    One that is too far from the last counts only if the next one confirms it. One that after a pause is nearer to zero
    than to the last is of a board that was reset. Nobody knows what the wheel turned meanwhile, and nothing is added.
    """

    def __init__(self) -> None:
        self.turning = CountAccumulator(WRAPS_AT)
        self._last: tuple[int, float] | None = None
        self._doubted: tuple[int, float] | None = None

    def take(self, count: int, time: float) -> None:
        """Take what the board has counted."""
        if self._last and _was_reset(count, time, *self._last):
            self.restart()
        elif self._last and not _follows(count, time, *self._last):
            if not (self._doubted and _follows(count, time, *self._doubted)):
                self._doubted = count, time
                return
            self.restart()
        self._last, self._doubted = (count, time), None
        self.turning.count(count, time)

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self._last = self._doubted = None
        self.turning.restart()


def _was_reset(count: int, time: float, before: int, then: float) -> bool:
    return time - then > MISSED_S and abs(count) < abs(_turned(count, before))


def _follows(count: int, time: float, before: int, then: float) -> bool:
    return abs(_turned(count, before)) <= math.ceil((time - then) * FASTEST_HZ)


def _turned(count: int, before: int) -> int:
    return (count - before + WRAPS_AT // 2) % WRAPS_AT - WRAPS_AT // 2


class Ranges:
    """Judges what our firmware tells: the newest range in mm, -1 where no echo came, and its age in ms."""

    def __init__(self, device: str, findings: RangeSampler) -> None:
        self._device, self._findings = device, findings
        self._last: float | None = None

    def take(self, answer: Answer, now: float) -> None:
        """Take an answer that came at ``now``."""
        if answer.is_refusal:
            return
        millimetres, age_ms = answer.numbers
        time = now - age_ms / 1000
        if age_ms > MUTE_S * 1000:
            self._findings.fail(DeviceError(self._device, _MUTE, kind="module-silent"))
        elif self._last is None or time - self._last > SAME_S:
            self._last = time
            self._judge(millimetres, time)

    def _judge(self, millimetres: int, time: float) -> None:
        if millimetres < 0:
            self._findings.clear_failure()
            self._findings.add_no_echo(time)
        else:
            self._findings.add_distance(millimetres / 1000, time)


class Pings:
    """Judges what the true ROSArduinoBridge measures when it is asked: cm, 0 where nothing came back in a second.

    A module that hears nothing ends its pulse by itself: what is out of range may be far, or may be that.
    """

    def __init__(self, description: RangeSensorDescription, findings: RangeSampler) -> None:
        self._description, self._findings = description, findings
        self._mute = 0

    def take(self, answer: Answer, now: float) -> None:
        """Take an answer that came at ``now``."""
        if answer.is_refusal:
            return
        distance = answer.numbers[0] / 100
        self._mute = 0 if distance else self._mute + 1
        if self._mute >= MUTE_PINGS:
            self._findings.fail(DeviceError(self._description.name, _MUTE, kind="module-silent"))
        elif not distance:
            self._findings.add_unclear()
        elif distance > self._description.max_range_m:
            self._findings.clear_failure()
            self._findings.add_no_echo(now)
        else:
            self._findings.add_distance(distance, now)


class Voltages:
    """Keeps what the board has told last."""

    def __init__(self, device: str) -> None:
        self._device = device
        self._newest: Voltage | None = None
        self._is_wired = True

    def take(self, answer: Answer, now: float) -> None:
        """Take an answer in mV, negative where no battery is wired."""
        if answer.is_refusal:
            return
        millivolts = answer.numbers[0]
        self._is_wired = millivolts >= 0
        if self._is_wired:
            self._newest = Voltage(millivolts / 1000, now, self._newest.sequence + 1 if self._newest else 0)

    def newest(self) -> Voltage | None:
        """Return the newest voltage, None where there was none yet; raises DeviceError where none is measured."""
        if not self._is_wired:
            raise DeviceError(self._device, NOT_WIRED, kind="battery-not-wired")
        return self._newest


class CountingMotor(BoardMotor):
    """Turns by as many counts a frame as come nearest to what is asked for, and returns the velocity that they are.

    What is less than half a count a frame is no command to turn: 0 is sent, and returned. ``counts_per_rad_s`` is what
    1 rad/s is in counts a frame; ``max_velocity`` is a whole number of them.
    """

    def __init__(self, description: MotorDescription, output: BoardOutput, counts_per_rad_s: float) -> None:
        super().__init__(description, output, counts_per_rad_s)
        self._counts_per_rad_s = counts_per_rad_s
        self.max_velocity = math.floor(description.max_velocity_rad_s * counts_per_rad_s) / counts_per_rad_s

    def set_velocity(self, rad_s: float) -> float:
        return round(super().set_velocity(rad_s) * self._counts_per_rad_s) / self._counts_per_rad_s

    def _apply(self, rad_s: float) -> None:
        super()._apply(round(rad_s * self._counts_per_rad_s) / self._counts_per_rad_s)


class Sonar(BoardSensor[Range], RangeSensor):
    """Tells what the board's module has found; where the line is lost, nothing."""

    def __init__(self, description: RangeSensorDescription, line: Line, findings: RangeSampler) -> None:
        RangeSensor.__init__(
            self,
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._line, self._findings = line, findings

    def await_first(self, within_s: float) -> None:
        self._line.wait_until(lambda: self._findings.has_result, self.name, within_s, self._no_sample_yet)
        self._newest()

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = self._findings.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest

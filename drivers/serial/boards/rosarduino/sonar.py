"""An ultrasonic module on a board."""

from __future__ import annotations

from drivers.serial.boards.devices import BoardSensor
from drivers.serial.boards.rosarduino.protocol import Answer
from drivers.serial.ports.line import Line
from robotcore.description import RangeSensorDescription
from robotcore.devices import Range, RangeSensor
from robotcore.errors import DeviceError
from robotcore.hardware.findings import Findings

SAME_S = 0.02
"""Ranges whose times are no farther apart are one: our firmware's cycle is 0.06 s, and it tells ages in ms."""

MUTE_S = 0.5
"""A module that has not answered a trigger for so long does not work."""

MUTE_PINGS = 3
"""So many questions in a row without a pulse, a second each, are a fault."""


class Sonar(BoardSensor[Range], RangeSensor):
    """Tells what the board's module has found; where the line is lost, nothing."""

    def __init__(self, told: RangeSensorDescription, line: Line, findings: Findings) -> None:
        RangeSensor.__init__(
            self, told.name, min_range=told.min_range_m, max_range=told.max_range_m, cone=told.cone_rad
        )
        self._line, self._findings = line, findings

    def await_first(self, within_s: float) -> None:
        self._line.wait_until(lambda: self._findings.has_told, self.name, within_s, self._untold)
        self._newest()

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = self._findings.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest


class Ranges:
    """Judges what our firmware tells: the newest range in mm, -1 where no echo came, and its age in ms."""

    def __init__(self, device: str, findings: Findings) -> None:
        self._device, self._findings = device, findings
        self._last: float | None = None

    def take(self, answer: Answer, now: float) -> None:
        """Take an answer that came at ``now``."""
        if answer.is_refusal:
            return
        millimetres, age_ms = answer.numbers
        time = now - age_ms / 1000
        if age_ms > MUTE_S * 1000:
            self._findings.failed(DeviceError(self._device, _MUTE))
        elif self._last is None or time - self._last > SAME_S:
            self._last = time
            self._judge(millimetres, time)

    def _judge(self, millimetres: int, time: float) -> None:
        if millimetres < 0:
            self._findings.recovered()
            self._findings.nothing(time)
        else:
            self._findings.found(millimetres / 1000, time)


class Pings:
    """Judges what the true ROSArduinoBridge measures when it is asked: cm, 0 where nothing came back in a second.

    A module that hears nothing ends its pulse by itself: what is out of range may be far, or may be that.
    """

    def __init__(self, told: RangeSensorDescription, findings: Findings) -> None:
        self._told, self._findings = told, findings
        self._mute = 0

    def take(self, answer: Answer, now: float) -> None:
        """Take an answer that came at ``now``."""
        if answer.is_refusal:
            return
        distance = answer.numbers[0] / 100
        self._mute = 0 if distance else self._mute + 1
        if self._mute >= MUTE_PINGS:
            self._findings.failed(DeviceError(self._told.name, _MUTE))
        elif not distance:
            self._findings.unclear()
        elif distance > self._told.max_range_m:
            self._findings.recovered()
            self._findings.nothing(now)
        else:
            self._findings.found(distance, now)


_MUTE = "the board's ultrasonic module does not answer its trigger; look at its 5 V, its ground and its pins"

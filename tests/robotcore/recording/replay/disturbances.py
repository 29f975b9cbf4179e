"""Disturbances from outside: an e-stop or a signal, between two ticks or during a tick."""

from __future__ import annotations

import signal

from robotcore.hal.devices import SampleT, Sensor
from robotcore.runtime.layers.base import Reader, Tap
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord


class Disturbance(Tap):
    """A tap and observer that disturbs a run from tick ``at`` on. Subclasses define the disturbance."""

    def __init__(self, at: int) -> None:
        self.at = at
        self.now = 0

    def begin(self, run: Run) -> None:
        """Do nothing, because the disturbance comes later."""

    def tick(self, record: TickRecord) -> None:
        self.now = record.tick + 1

    def end(self, result: RunResult) -> None:
        """Do nothing, because the disturbance came before, or the run ended earlier."""


class EmergencyStopBetween(Disturbance):
    """Presses the e-stop between two ticks."""

    def begin(self, run: Run) -> None:
        self._button = run.emergency

    def tick(self, record: TickRecord) -> None:
        super().tick(record)
        if self.now == self.at:
            self._button.press("the button was pressed")


class EmergencyStopInTick(EmergencyStopBetween):
    """Presses the e-stop during a step of the app."""

    def tick(self, record: TickRecord) -> None:
        self.now = record.tick + 1

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def reader() -> SampleT:
            if self.now >= self.at:
                self._button.press("the button was pressed")
            return read()

        return reader


class SignalInTick(Disturbance):
    """Sends a signal to the process during a step of the app."""

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def reader() -> SampleT:
            if self.now == self.at:
                signal.raise_signal(signal.SIGTERM)
            return read()

        return reader


class SignalBetween(Disturbance):
    """Sends a signal to the process between two ticks."""

    def tick(self, record: TickRecord) -> None:
        super().tick(record)
        if self.now == self.at:
            signal.raise_signal(signal.SIGINT)

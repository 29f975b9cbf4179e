"""An ultrasonic module at work."""

from __future__ import annotations

from contextlib import ExitStack

from drivers.raspberrypi.ranging.echopins import EchoPins
from drivers.raspberrypi.ranging.hearing import Hearing
from drivers.raspberrypi.ranging.turns import Turns
from robotcore.description import RangeSensorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware.polled import Findings


class Sonar(RangeSensor):
    """Triggers the module whenever it is its turn; the falling edge of its echo tells the distance."""

    def __init__(
        self,
        told: RangeSensorDescription,
        findings: Findings,
        hearing: Hearing,
        pins: EchoPins,
        clock: Clock,
        turns: Turns,
        cycle_s: float,
    ) -> None:
        super().__init__(told.name, min_range=told.min_range_m, max_range=told.max_range_m, cone=told.cone_rad)
        self._findings, self._hearing, self._pins = findings, hearing, pins
        self._clock, self._turns, self._cycle_s = clock, turns, cycle_s
        self._stopping = ExitStack()

    def start(self, first_cycles: int) -> None:
        """Hear something within so many cycles, then go on beside the app; raises DeviceError."""
        self._stopping.callback(self._pins.close)
        self._stopping.callback(self._hearing.stop)
        self._pins.listen(self._hearing.edge)
        self._turns.pause()
        for _ in range(first_cycles):
            self._cycle()
            self._hearing.ended.wait(self._cycle_s)
            if self._findings.has_told:
                break
        self._newest()
        self._stopping.callback(self._turns.leave, self._cycle)
        self._turns.join(self._cycle, self._cycle_s)

    def _cycle(self) -> None:
        try:
            self._trigger()
        except Exception as error:  # noqa: BLE001  told by whoever reads
            self._hearing.fail(error)

    def _trigger(self) -> None:
        if self._pins.is_high:
            self._hearing.wait()
            return
        self._hearing.begin(self._clock.now(), self._pins.ticks())
        self._pins.trigger()

    def _newest(self) -> Range:
        return self._findings.newest.get()

    def _release(self) -> None:
        self._stopping.close()

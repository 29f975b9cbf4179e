"""A time-of-flight chip at work."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from contextlib import ExitStack

from drivers.raspberrypi.ranging.i2c import I2CChip
from drivers.raspberrypi.ranging.lightchips import Measurement, Seen
from robotcore.description import RangeSensorDescription
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware.polled import Findings

STALLED_S = 1.0
"""A chip that has measured nothing for so long was without power meanwhile, and measures no more by itself."""


class Lidar(RangeSensor):
    """Asks its chip once a cycle for what it has measured since; where the chip has failed, it is connected again.

    ``connect`` raises DeviceError. A sample's time is that of the question before the one it answers: the light that it
    is made from came later, or at most one measurement (50 ms) earlier.
    """

    def __init__(
        self, told: RangeSensorDescription, findings: Findings, connect: Callable[[], I2CChip], clock: Clock
    ) -> None:
        super().__init__(told.name, min_range=told.min_range_m, max_range=told.max_range_m, cone=told.cone_rad)
        self._findings, self._connect, self._clock = findings, connect, clock
        self._chip: I2CChip | None = None
        self._asked = self._measured = 0.0
        self._stopping = ExitStack()

    def start(self, cycle_s: float, first_cycles: int) -> None:
        """See something within so many cycles, then go on beside the app; raises DeviceError."""
        self._asked = self._clock.now()
        self._stopping.callback(self._disconnect)
        never = threading.Event()
        for _ in range(first_cycles):
            self._poll()
            if self._findings.has_told:
                break
            never.wait(cycle_s)
        self._newest()
        self._stopping.callback(self._clock.every(cycle_s, self._poll, self.name).stop)

    def _poll(self) -> None:
        try:
            self._ask()
        except DeviceError as error:
            self._disconnect()
            self._findings.failed(error)

    def _ask(self) -> None:
        before, self._asked = self._asked, self._clock.now()
        if self._chip is None:
            self._chip, self._measured = self._connect(), self._asked
        measurement = self._chip.measure()
        if measurement is not None:
            self._measured = self._asked
            self._judge(measurement, before)
        elif self._asked - self._measured > STALLED_S:
            raise DeviceError(self.name, "has stopped measuring; look at its 3.3 V")

    def _judge(self, measurement: Measurement, time: float) -> None:
        if measurement.seen is Seen.BROKEN:
            raise DeviceError(self.name, "says that its laser is broken; switch its 3.3 V off and on, or replace it")
        self._findings.recovered()
        match measurement.seen:
            case Seen.TARGET:
                self._findings.found(measurement.distance, time)
            case Seen.TOO_NEAR:
                self._findings.found(0.0, time)
            case Seen.BEYOND:
                self._findings.found(math.inf, time)
            case Seen.NOTHING:
                self._findings.nothing(time)
            case _:
                self._findings.unclear()

    def _disconnect(self) -> None:
        chip, self._chip = self._chip, None
        if chip is not None:
            chip.close()

    def _newest(self) -> Range:
        return self._findings.newest.get()

    def _release(self) -> None:
        self._stopping.close()

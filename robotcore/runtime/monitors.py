"""Monitors that run beside the app: battery voltages, and devices that are lost for a while."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite

from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.devices import Battery, Voltage
from robotcore.hal.robot import Robot

PERIOD_S = 1.0
"""How often a battery is read, on the robot's clock: it changes in minutes."""

PATIENCE_S = 3.0
"""A motor that starts pulls the voltage down for a moment, which says nothing of how full a battery is."""


class BatteryMonitor:
    """Reads every battery of a robot once a second, whatever its app reads. Nobody drives by what they tell.

    ``voltages`` are what they told last, by name, in volts; it is another mapping where there is something new.
    """

    def __init__(self, robot: Robot) -> None:
        self._gauges = [BatteryGauge(device) for device in robot.devices.values() if isinstance(device, Battery)]
        self._due = -inf if self._gauges else inf
        self.voltages: Mapping[str, float] = {}

    def read(self, now: float) -> tuple[str, ...]:
        """Read what is due at a time; return what is new and to be known, in whole sentences."""
        if now < self._due:
            return ()
        self._due = now + PERIOD_S
        warnings = [gauge.read() for gauge in self._gauges]
        self.voltages = {gauge.name: gauge.voltage for gauge in self._gauges if gauge.voltage is not None}
        return tuple(filter(None, warnings))


class BatteryGauge:
    """Reads one battery, and warns once where it is low, and once where it does not tell."""

    def __init__(self, battery: Battery) -> None:
        self.name = battery.name
        self.voltage: float | None = None
        self._battery = battery
        self._fine_at = -inf
        self._has_failed = self._was_low = False

    def read(self) -> str:
        """Take the newest voltage; return a warning, or nothing."""
        try:
            sample = self._battery.read()
        except DeviceError as failure:
            return self._read_failure_warning(str(failure))
        if not isfinite(sample.voltage):
            return self._read_failure_warning(
                f"{self.name}: {sample.voltage} V is no voltage. Report it to whoever wrote its driver"
            )
        self.voltage = sample.voltage
        return self._low_voltage_warning(sample)

    def _read_failure_warning(self, why: str) -> str:
        has_failed, self._has_failed = self._has_failed, True
        return "" if has_failed else f"{why.rstrip('.')}. The run goes on: nobody drives by it"

    def _low_voltage_warning(self, sample: Voltage) -> str:
        """Return a warning where the voltage stays too low. Before the first command no motor can be the reason."""
        limit = self._battery.warn_below
        if limit is None or sample.voltage >= limit:
            self._fine_at = sample.time
        elif not self._was_low and sample.time - self._fine_at >= PATIENCE_S:
            self._was_low = True
            return f"{self.name}: {sample.voltage:.2f} V, and it is to be charged below {limit:g} V. Charge it"
        return ""


class DeviceLossTracker:
    """Tells whether a run may go on without a device that is lost, for up to ``limit`` seconds at a time.

    ``lost`` are the names of those that are, in the order in which they were missed: it ends when all are back.
    """

    def __init__(self, limit: float) -> None:
        self.lost: list[str] = []
        self._limit = limit
        self._since = 0.0
        self._past_losses: list[tuple[str, float]] = []

    @property
    def is_enabled(self) -> bool:
        """Whether a loss is waited for at all."""
        return self._limit > 0

    def tolerates(self, lost: DeviceLostError, now: float) -> bool:
        """Take in a tick in which a device was lost; return whether there may be another one."""
        if not self.is_enabled:
            return False
        if not self.lost:
            self._since = now
        if lost.device not in self.lost:
            self.lost.append(lost.device)
        return now - self._since < self._limit

    def end(self, now: float) -> None:
        """Take in a tick in which nothing was lost."""
        if self.lost:
            self._past_losses.append((self.lost[0], now - self._since))
            self.lost.clear()

    def notes(self, now: float) -> tuple[str, ...]:
        """Return what the end of a run tells: which devices, how often, how long in all; and what was not back."""
        names = sorted({name for name, _ in self._past_losses})
        away = f"{', '.join(self.lost)} was lost for the last {now - self._since:.1f} s; the robot stood"
        return (*map(self._note, names), *([away] if self.lost else ()))

    def _note(self, device: str) -> str:
        lengths = [length for name, length in self._past_losses if name == device]
        often = "once" if len(lengths) == 1 else f"{len(lengths)} times"
        return f"{device} was lost {often}, {sum(lengths):.1f} s in all, and came back; the robot stood meanwhile"

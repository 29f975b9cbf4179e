"""A battery whose voltage is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from pydantic import Field

from robotcore.description import DeviceDescription
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.robot import Robot

__all__ = ["KIND", "Battery", "BatteryDescription", "Voltage"]


class BatteryDescription(DeviceDescription):
    """A battery whose voltage is measured.

    >>> BatteryDescription(kind="battery", name="battery", warn_below_v=6.6)
    BatteryDescription(kind='battery', name='battery', warn_below_v=6.6)
    """

    kind: Literal["battery"]
    warn_below_v: Annotated[float, Field(ge=0.1, le=1000)] | None = None
    """The voltage, in volts, below which the user is warned to charge the battery; None for no warning."""

    def configure(self, device: Battery) -> None:
        device.warn_below = self.warn_below_v


@dataclass(frozen=True, slots=True)
class Voltage:
    """A sample of a battery.

    >>> Voltage(voltage=7.4, time=1.25, sequence=1)
    Voltage 7.40 V at 1.25 s
    """

    voltage: Annotated[float, Unit("V")]
    """The voltage of the battery, in volts."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class Battery(Sensor[Voltage]):
    """A sensor that measures the voltage of a battery.

    A run warns below ``warn_below`` volts, a limit that the run sets from the robot's description.

    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.battery import BatteryDescription, Voltage
    >>> description = BatteryDescription(kind="battery", name="battery", warn_below_v=6.6)
    >>> battery = build_sensor(description, lambda: Voltage(6.4, 1.25, 1))
    >>> description.configure(battery)
    >>> battery.find_problem(battery.read())
    '6.40 V is below the limit of 6.6 V. Charge the battery'
    """

    kind = "battery"
    is_monitored = True
    warn_below: float | None = None

    def limit_sample(self, sample: Voltage) -> Voltage:
        return replace(sample, voltage=max(sample.voltage, 0.0))

    def find_problem(self, sample: Voltage) -> str:
        limit = self.warn_below
        if limit is None or sample.voltage >= limit:
            return ""
        return f"{sample.voltage:.2f} V is below the limit of {limit:g} V. Charge the battery"


SETTLING_S = 5.0
"""The time after the opening before the voltage is checked, in seconds. A driver measures it at least once in it."""


def check_voltage(robot: Robot, battery: Battery) -> None:
    """Check that the voltage is a number above zero."""
    robot.clock.sleep_until(robot.clock.now() + SETTLING_S)
    voltage = battery.read().voltage
    assert math.isfinite(voltage), f"{battery.name} returned {voltage} V. Raise DeviceError without a measured voltage"
    assert voltage > 0, f"{battery.name} returned {voltage} V. Return the voltage in volts, above zero"


KIND = Kind(
    "a battery whose voltage is measured",
    BatteryDescription,
    Battery,
    Voltage,
    rules=(check_voltage,),
    is_optional=True,
)
"""The kind `battery`, which the entry point of this name refers to."""

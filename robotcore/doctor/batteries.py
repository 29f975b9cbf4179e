"""The batteries that a backend tells of: each is opened and read, nothing else of the robot is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from robotcore.backend import Backend, Setup
from robotcore.description import BatteryDescription, RobotDescription
from robotcore.devices import Battery
from robotcore.doctor.finding import Finding
from robotcore.errors import DescriptionError

CHARGE = "Charge it, or take another one"
UNTOLD = "Look whether it is switched on and connected, and whether another program has its port"


def batteries_of(backend: Backend, robot: RobotDescription) -> Iterator[Finding]:
    """Yield the voltage of each battery, and whether it is to be charged. Raises what opening raises."""
    limits = {told.name: told.warn_below_v for told in robot.all_of(BatteryDescription)}
    names = backend.batteries(robot, {}) if limits and backend.is_installed else None
    if not names:
        return
    with suppress(DescriptionError), backend.open(Setup(robot, None, names)) as opened:  # of a file, `examine` has told
        for note in opened.notes:
            yield Finding.unchecked("battery", note, UNTOLD)
        for device in opened.devices.values():
            if isinstance(device, Battery):
                yield _judged(device.name, device.read().voltage, limits[device.name])


def _judged(name: str, voltage: float, limit: float | None) -> Finding:
    if limit is not None and voltage < limit:
        return Finding.warning(name, f"{voltage:.2f} V, and it is to be charged below {limit:g} V", CHARGE)
    return Finding.ok(name, f"{voltage:.2f} V" + (f", to be charged below {limit:g} V" if limit is not None else ""))

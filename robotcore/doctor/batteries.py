"""The batteries that a backend tells of: what each has, and whether that is enough."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from robotcore.backend import Backend, Setup
from robotcore.description import BatteryDescription, RobotDescription
from robotcore.devices import Battery
from robotcore.doctor.finding import Finding
from robotcore.errors import DescriptionError, DeviceError
from robotcore.robot import Robot

CHARGE = "Charge it, or take another one"
UNTOLD = "Look whether it is switched on and connected, and whether another program has its port"


def batteries_of(backend: Backend, robot: RobotDescription) -> Iterator[Finding]:
    """Open the batteries of a robot, and nothing else of it; yield what they have. Raises what opening raises."""
    if not robot.all_of(BatteryDescription) or not (names := backend.batteries(robot, {})):
        return
    with suppress(DescriptionError), backend.open(Setup(robot, None, names)) as opened:  # of a file, `examine` has told
        yield from charges(robot, opened)


def charges(robot: RobotDescription, opened: Robot) -> Iterator[Finding]:
    """Yield the voltage of each battery that is open, whether it is to be charged, and why another one is not open."""
    for note in opened.notes:
        yield _unchecked("battery", note)
    for told in robot.all_of(BatteryDescription):
        if isinstance(battery := opened.devices.get(told.name), Battery):
            try:
                yield _judged(told, battery.read().voltage)
            except DeviceError as failure:
                yield _unchecked(told.name, str(failure))


def _unchecked(what: str, fault: str) -> Finding:
    """Return that a battery's voltage is not known; a fault that says what to do needs no other advice."""
    return Finding.unchecked(what, fault, "" if ". " in fault or "; " in fault else UNTOLD)


def _judged(told: BatteryDescription, voltage: float) -> Finding:
    limit = told.warn_below_v
    if limit is None:
        return Finding.ok(told.name, f"{voltage:.2f} V")
    if voltage < limit:
        return Finding.warning(told.name, f"{voltage:.2f} V, and it is to be charged below {limit:g} V", CHARGE)
    return Finding.ok(told.name, f"{voltage:.2f} V, to be charged below {limit:g} V")

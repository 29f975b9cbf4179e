"""Findings about a robot's batteries and its description."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress

from robotcore.description import BatteryDescription, RobotDescription
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.devices import Battery
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot
from robotcore.hardware import Fitting

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


def described(
    robot: RobotDescription,
    fit: Callable[[], Sequence[Fitting]],
    count_parts: Callable[[Sequence[Fitting]], str],
) -> Generator[Finding, None, Sequence[Fitting] | None]:
    """Yield what is wrong with the file, or that it is right, how much it has, and what of it may do harm.

    Returns the devices as they are fitted, None where the file is wrong.
    """
    try:
        fittings = fit()
    except DescriptionError as error:
        for each in (error, *error.others):
            yield Finding.error("robot", f"{each.key}: {each.fault}", each.remedy)
        return None
    yield Finding.ok("robot", f"{robot.file or robot.name} OK, {count_parts(fittings)}")
    for fitting in fittings:
        for warning in fitting.warnings:
            said, _, remedy = warning.partition(". ")
            yield Finding.warning("robot", f"{fitting.name}: {said}", remedy)
    return fittings

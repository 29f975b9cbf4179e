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
from robotcore.hardware import DeviceBinding

CHARGE = "Charge it, or take another one"
UNREAD_REMEDY = "Look whether it is switched on and connected, and whether another program has its port"


def diagnose_batteries(backend: Backend, robot: RobotDescription) -> Iterator[Finding]:
    """Open the batteries of a robot, and nothing else of it; yield what they have. Raises what opening raises."""
    if not robot.all_of(BatteryDescription) or not (names := backend.batteries(robot, {})):
        return
    with suppress(DescriptionError), backend.open(Setup(robot, None, names)) as opened:  # of a file, `examine` has told
        yield from check_batteries(robot, opened)


def check_batteries(robot: RobotDescription, opened: Robot) -> Iterator[Finding]:
    """Yield the voltage of each battery that is open, whether it is to be charged, and why another one is not open."""
    for note in opened.notes:
        yield _unchecked_finding("battery", note)
    for description in robot.all_of(BatteryDescription):
        if isinstance(battery := opened.devices.get(description.name), Battery):
            try:
                yield _judge_voltage(description, battery.read().voltage)
            except DeviceError as failure:
                yield _unchecked_finding(description.name, str(failure))


def _unchecked_finding(what: str, fault: str) -> Finding:
    """Return that a battery's voltage is not known; a fault that says what to do needs no other advice."""
    remedy = "" if ". " in fault or "; " in fault else UNREAD_REMEDY
    return Finding.unchecked(what, fault, remedy, kind="battery-unread")


def _judge_voltage(description: BatteryDescription, voltage: float) -> Finding:
    limit = description.warn_below_v
    if limit is None:
        return Finding.ok(description.name, f"{voltage:.2f} V", kind="battery-ok")
    if voltage < limit:
        said = f"{voltage:.2f} V, and it is to be charged below {limit:g} V"
        return Finding.warning(description.name, said, CHARGE, kind="battery-low")
    return Finding.ok(description.name, f"{voltage:.2f} V, to be charged below {limit:g} V", kind="battery-ok")


def check_description(
    robot: RobotDescription,
    bind: Callable[[], Sequence[DeviceBinding]],
    count_parts: Callable[[Sequence[DeviceBinding]], str],
) -> Generator[Finding, None, Sequence[DeviceBinding] | None]:
    """Yield what is wrong with the file, or that it is right, how much it has, and what of it may do harm.

    Returns the devices as they are fitted, None where the file is wrong.
    """
    try:
        bindings = bind()
    except DescriptionError as error:
        for each in (error, *error.others):
            yield Finding.error("robot", f"{each.key}: {each.problem}", each.remedy, kind=each.kind)
        return None
    yield Finding.ok("robot", f"{robot.file or robot.name} OK, {count_parts(bindings)}", kind="description-ok")
    for binding in bindings:
        for warning in binding.warnings:
            said, _, remedy = warning.partition(". ")
            yield Finding.warning("robot", f"{binding.name}: {said}", remedy, kind="connection-risk")
    return bindings

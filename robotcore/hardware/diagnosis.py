"""Findings of `robotcore doctor` about a robot's batteries and its description."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress

from robotcore.description import BatteryDescription, RobotDescription
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.devices import Battery
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceBinding

CHARGE = "Charge or replace the battery"
UNREAD_REMEDY = "Check that it is switched on and connected, and that no other program uses its port"


def diagnose_batteries(backend: Backend, robot: RobotDescription) -> Iterator[Finding]:
    """Open the batteries of a robot and no other device; yield a finding for each. Raises errors of the opening."""
    if not robot.all_of(BatteryDescription) or not (names := backend.batteries(robot, {})):
        return
    with suppress(DescriptionError), backend.open(Setup(robot, None, names)) as opened:  # `examine` reports the file
        yield from check_batteries(robot, opened)


def check_batteries(robot: RobotDescription, opened: Robot) -> Iterator[Finding]:
    """Yield a finding for each battery: its voltage and whether it must be charged, or why it could not be opened."""
    for note in opened.notes:
        yield _unchecked_finding("battery", note)
    for description in robot.all_of(BatteryDescription):
        if isinstance(battery := opened.devices.get(description.name), Battery):
            try:
                yield _judge_voltage(description, battery.read().voltage)
            except DeviceError as failure:
                yield _unchecked_finding(description.name, str(failure))


def _unchecked_finding(what: str, fault: str) -> Finding:
    """Return a finding about an unknown voltage. If the fault has no remedy, a general one is added."""
    remedy = "" if ". " in fault or "; " in fault else UNREAD_REMEDY
    return Finding.unchecked(what, fault, remedy, kind="battery-unread")


def _judge_voltage(description: BatteryDescription, voltage: float) -> Finding:
    limit = description.warn_below_v
    if limit is None:
        return Finding.ok(description.name, f"{voltage:.2f} V", kind="battery-ok")
    if voltage < limit:
        said = f"{voltage:.2f} V, below the limit of {limit:g} V"
        return Finding.warning(description.name, said, CHARGE, kind="battery-low")
    return Finding.ok(description.name, f"{voltage:.2f} V, not below the limit of {limit:g} V", kind="battery-ok")


def check_description(
    robot: RobotDescription,
    bind: Callable[[], Sequence[DeviceBinding]],
    count_parts: Callable[[Sequence[DeviceBinding]], str],
) -> Generator[Finding, None, Sequence[DeviceBinding] | None]:
    """Yield findings about a robot's file: its mistakes, or if there are none, the risks in its connections.

    bind: returns the devices with their drivers, or raises DescriptionError.
    count_parts: returns a text with the number of devices, for the finding.
    Returns the devices with their drivers; None if the file has mistakes.
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

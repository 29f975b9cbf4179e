"""Findings of `robotcore doctor` about a robot's batteries and its description."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress

from robotcore.description import RobotDescription
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceBinding
from robotcore.kinds.battery import Battery, BatteryDescription

CHARGE = "Charge or replace the battery"
UNREAD_REMEDY = "Check that the board is switched on and connected, and that no other program uses its port"


def diagnose_batteries(backend: Backend, robot: RobotDescription) -> Iterator[Finding]:
    """Open only the batteries of a robot, and yield a finding for each battery. Raises the errors of `Backend.open`."""
    if not robot.all_of(BatteryDescription) or not (names := backend.batteries(robot, {})):
        return
    with suppress(DescriptionError), backend.open(Setup(robot, None, names)) as opened:  # `examine` reports the file
        yield from check_batteries(robot, opened)


def check_batteries(robot: RobotDescription, opened: Robot) -> Iterator[Finding]:
    """Yield a finding about the voltage of each battery, or about the failure to open or read it.

    robot: the description of the robot.
    opened: the robot with its open batteries.
    """
    for note in opened.notes:
        yield _unchecked_finding("battery", note)
    for description in robot.all_of(BatteryDescription):
        if isinstance(battery := opened.devices.get(description.name), Battery):
            try:
                yield _judge_voltage(description, battery.read().voltage)
            except DeviceError as failure:
                yield _unchecked_finding(description.name, str(failure))


def _unchecked_finding(subject: str, problem: str) -> Finding:
    """Return a finding about an unknown voltage, with a general remedy if the problem's text has no remedy."""
    remedy = "" if ". " in problem or "; " in problem else UNREAD_REMEDY
    return Finding.unchecked(subject, problem, remedy, kind="battery-unread")


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
    """Yield findings about the mistakes in a robot's file, and about the risks in its connections.

    bind: returns the devices with their drivers, or raises DescriptionError.
    count_parts: returns a text with the number of devices. It is the finding for a file without mistakes.

    Returns the devices with their drivers, or None if the file has mistakes.
    """
    try:
        bindings = bind()
    except DescriptionError as error:
        for each in (error, *error.others):
            yield Finding.error("robot", f"{each.key}: {each.problem}", each.remedy, kind=each.kind)
        return None
    yield Finding.ok("robot", f"{robot.file or robot.name} OK, {count_parts(bindings)}", kind="description-ok")
    for binding in bindings:
        for warning in binding.driver.warnings():
            said, _, remedy = warning.partition(". ")
            yield Finding.warning("robot", f"{binding.name}: {said}", remedy, kind="connection-risk")
    return bindings

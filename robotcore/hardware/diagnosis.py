"""Findings of `robotcore doctor` about a robot's monitored sensors and its description."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.device import Sensor
from robotcore.hal.kind import list_monitored
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceBinding

UNREAD_REMEDY = "Check that the board is switched on and connected, and that no other program uses its port"


def diagnose_monitored(backend: Backend, robot: RobotDescription) -> Iterator[Finding]:
    """Open only the monitored sensors of a robot, such as its battery, and yield a finding for each.

    Raises the errors of `Backend.open`.
    """
    if not (names := list_monitored(robot) & backend.openable(robot, {})):
        return
    with suppress(DescriptionError), backend.open(Setup(robot, None, names)) as opened:  # `examine` reports the file
        yield from check_monitored(robot, opened)


def check_monitored(robot: RobotDescription, opened: Robot) -> Iterator[Finding]:
    """Yield a finding about the value of each monitored sensor, or about the failure to open or read it.

    robot: the description of the robot.
    opened: the robot with its open sensors.
    """
    for note in opened.notes:
        yield _build_unread("sensor", note)
    for description in robot.devices:
        sensor = opened.devices.get(description.name)
        if isinstance(sensor, Sensor) and sensor.is_monitored:
            description.configure(sensor)
            try:
                yield _judge(sensor)
            except DeviceError as failure:
                yield _build_unread(sensor.name, str(failure))


def _build_unread(subject: str, problem: str) -> Finding:
    """Return a finding about an unknown value, with a general remedy if the problem's text has no remedy."""
    remedy = "" if ". " in problem or "; " in problem else UNREAD_REMEDY
    return Finding.unchecked(subject, problem, remedy, kind="sensor-unread")


def _judge(sensor: Sensor[Any]) -> Finding:
    sample = sensor.read()
    if problem := sensor.find_problem(sample):
        said, _, remedy = problem.partition(". ")
        return Finding.warning(sensor.name, said, remedy, kind="sensor-problem")
    return Finding.ok(sensor.name, sensor.format_sample(sample), kind="sensor-ok")


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

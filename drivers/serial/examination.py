"""The checks of `robotcore doctor` for the backend `serial`: ports and boards."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from drivers.serial.boards.board import SharedBoardError
from drivers.serial.driver import PortSettings, summarize_devices
from drivers.serial.port import Port, PortError, describe_ports, find_other_users
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError, DeviceGroupError, RobotcoreError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Check, Finding, Level, findings_of
from robotcore.hal.devices import Angle, Device, Frame, Range, Sensor, Voltage
from robotcore.hardware import DeviceBinding, bind_devices
from robotcore.hardware.diagnosis import check_batteries, check_description

MUTE = "Lift the robot, and turn its wheels for a moment"


def examine(backend: Backend, robot: RobotDescription | None, section: str) -> Iterator[Finding]:
    """Yield the findings about the computer's ports, and about the ports and boards of a robot.

    No motor turns, but opening a port resets an Arduino.

    robot: None checks only the computer.
    section: the name of the section in the robot's file that lists the devices and their ports.
    """
    if not backend.is_installed:
        yield Finding.warning(backend.name, "is not installed", backend.remedy, kind="not-installed")
        return
    yield Finding.ok("ports", describe_ports(), kind="ports")
    if robot is None:
        remedy = "Name the robot: robotcore doctor --robot FILE.toml"
        yield Finding.warning("robot", "no robot was named, so no robot's ports are checked", remedy, kind="no-robot")
    elif section in robot.backends:
        yield from _examine_robot(backend, robot, section)
    else:
        message = f"{robot.source} has no section [{section}], so no device is on a serial port"
        yield Finding.warning("robot", message, "Name another robot; robotcore robots lists them", kind="no-section")


def _examine_robot(backend: Backend, robot: RobotDescription, section: str) -> Iterator[Finding]:
    bindings = yield from check_description(robot, partial(bind_devices, robot, section), summarize_devices)
    if bindings is None:
        return
    found = [_check_port(place, baud) for place, baud in _list_lines(bindings)]
    yield from found
    checks: list[tuple[str, Check]] = [
        (what := each.description.kind, partial(_check_other_device, backend, robot, each.name, what))
        for each in bindings
        if not isinstance(each.settings, PortSettings)
    ]
    if not any(finding.level is Level.ERROR for finding in found):
        checks.insert(0, ("boards", partial(_check_boards, backend, robot, bindings)))
    yield from findings_of(checks)


def _list_lines(bindings: Iterable[DeviceBinding]) -> list[tuple[str, int]]:
    all_settings = (binding.settings for binding in bindings)
    return list(dict.fromkeys((each.port, each.speed) for each in all_settings if isinstance(each, PortSettings)))


def _check_port(place: str, baud: int) -> Finding:
    port = Port(place, baud)
    try:
        port.open()
    except PortError as error:
        message, _, remedy = str(error).partition(". ")
        return Finding.error("port", message, remedy, kind="port-not-opened")
    port.close()
    if shared := find_other_users(place):
        return Finding.warning("port", *shared, kind="port-shared")
    return Finding.ok("port", f"{place} opens at {baud} baud", kind="port-ok")


def _check_boards(backend: Backend, robot: RobotDescription, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    serial = {each.name: each.settings for each in bindings if isinstance(each.settings, PortSettings)}
    mute = [name for name, settings in serial.items() if settings.is_mute]
    try:
        with backend.open(Setup(robot, None, frozenset(serial))) as opened:
            if readings := [_format_device(device) for name, device in opened.devices.items() if name not in mute]:
                yield Finding.ok("boards", "; ".join(readings), kind="boards-ok")
            if mute:
                message = f"{' and '.join(mute)}: their board never answers"
                yield Finding.unchecked("boards", message, MUTE, kind="board-mute")
            yield from check_batteries(robot, opened)
    except DeviceGroupError as error:
        yield from (_error_finding("boards", each) for each in error.failures if not isinstance(each, SharedBoardError))
    except DeviceError as error:
        yield _error_finding("boards", error)


def _check_other_device(backend: Backend, robot: RobotDescription, name: str, what: str) -> Iterator[Finding]:
    try:
        with backend.open(Setup(robot, None, frozenset([name]))) as opened:
            yield Finding.ok(what, _format_device(opened.devices[name]), kind="device-ok")
    except DeviceGroupError as error:
        yield from (_error_finding(what, each) for each in error.failures)
    except DeviceError as error:
        yield _error_finding(what, error)


def _error_finding(what: str, error: Exception) -> Finding:
    message, _, remedy = str(error).partition(". ")
    kind = error.kind if isinstance(error, RobotcoreError) else "device"
    return Finding.error(what, message, remedy or "Check its wires and its power", kind=kind)


def _format_device(device: Device) -> str:
    if not isinstance(device, Sensor):
        return f"{device.name} is open"
    try:
        return f"{device.name} reads {_format_sample(device.read())}"
    except DeviceError:
        return f"{device.name} has no sample yet"


def _format_sample(sample: Any) -> str:
    match sample:
        case Range(distance=distance):
            return f"{distance:.2f} m"
        case Angle(angle=angle):
            return f"{round(angle, 2) + 0.0:.2f} rad"  # no -0.00
        case Frame(image=image):
            return f"{image.shape[1]} x {image.shape[0]} pixels"
        case Voltage(voltage=voltage):
            return f"{voltage:.1f} V"
    return "something"

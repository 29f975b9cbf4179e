"""The checks of `robotcore doctor` for the backend `serial`: ports and boards."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from functools import partial

from drivers.serial.boards.drivers import SharedBoardError
from drivers.serial.driver import SerialDriver
from drivers.serial.port import Port, PortError, describe_ports, find_other_users
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError, DeviceGroupError, RobotcoreError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Check, Finding, Level, findings_of
from robotcore.hal.device import Device, Sensor
from robotcore.hardware import HardwareBackend
from robotcore.hardware.diagnosis import check_description, check_monitored

MUTE = "Lift the robot, and turn its wheels for a moment"


def examine(backend: HardwareBackend, robot: RobotDescription | None) -> Iterator[Finding]:
    """Yield the findings about the computer's ports, and about the ports and boards of a robot.

    No motor turns, but opening a port resets an Arduino.

    robot: None checks only the computer.
    """
    if not backend.is_installed:
        yield Finding.warning(backend.name, "is not installed", backend.remedy, kind="not-installed")
        return
    yield Finding.ok("ports", describe_ports(), kind="ports")
    if robot is None:
        remedy = "Name the robot: robotcore doctor --robot FILE.toml"
        yield Finding.warning("robot", "no robot was named, so no robot's ports are checked", remedy, kind="no-robot")
    elif backend.section in robot.backends:
        yield from _examine_robot(backend, robot)
    else:
        message = f"{robot.source} has no section [{backend.section}], so no device is on a serial port"
        yield Finding.warning("robot", message, "Name another robot; robotcore robots lists them", kind="no-section")


def _examine_robot(backend: HardwareBackend, robot: RobotDescription) -> Iterator[Finding]:
    bindings = yield from check_description(robot, partial(backend.bind, robot), backend.summarize)
    if bindings is None:
        return
    serial = {each.name: each.driver for each in bindings if isinstance(each.driver, SerialDriver)}
    lines = dict.fromkeys((driver.port, driver.effective_baud) for driver in serial.values())
    found = [_check_port(place, baud) for place, baud in lines]
    yield from found
    mute = [name for name, driver in serial.items() if driver.is_mute]
    checks: list[tuple[str, Check]] = []
    if not any(finding.level is Level.ERROR for finding in found):
        checks.append(("boards", partial(_check_devices, backend, robot, "boards", serial, mute)))
    for each in bindings:
        if each.name not in serial:
            what = each.description.kind
            checks.append((what, partial(_check_devices, backend, robot, what, [each.name])))
    yield from findings_of(checks)


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


def _check_devices(
    backend: Backend, robot: RobotDescription, what: str, names: Iterable[str], mute: Collection[str] = ()
) -> Iterator[Finding]:
    try:
        with backend.open(Setup(robot, None, frozenset(names))) as opened:
            if readings := [_format_device(device) for name, device in opened.devices.items() if name not in mute]:
                yield Finding.ok(what, "; ".join(readings), kind="boards-ok" if what == "boards" else "device-ok")
            if mute:
                message = f"{' and '.join(mute)}: their board never answers"
                yield Finding.unchecked(what, message, MUTE, kind="board-mute")
            yield from check_monitored(robot, opened)
    except DeviceGroupError as error:
        yield from (_error_finding(what, each) for each in error.failures if not isinstance(each, SharedBoardError))
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
        sample = device.read()
    except DeviceError:
        return f"{device.name} has no sample yet"
    return f"{device.name} reads {device.format_sample(sample)}"

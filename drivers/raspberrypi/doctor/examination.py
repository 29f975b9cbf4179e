"""The list of all checks of `robotcore doctor` on a Raspberry Pi."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from drivers.raspberrypi.doctor.board import (
    check_board,
    check_clock,
    check_disk,
    check_power,
    check_release,
    is_raspberry_pi,
)
from drivers.raspberrypi.doctor.pins import check_library, check_persistence, check_pins
from drivers.raspberrypi.doctor.ports import check_bus, check_cameras, check_permissions, check_picamera2, check_serial
from drivers.raspberrypi.header import count_wires, resolve_pins
from robotcore.description import RobotDescription
from robotcore.hal.check_finding import Check, Finding, findings_of
from robotcore.hardware import DeviceBinding, bind_devices
from robotcore.hardware.diagnosis import check_description

ROOT = Path("/")


def examine(robot: RobotDescription | None, section: str, root: Path = ROOT) -> Iterator[Finding]:
    """Yield the findings about this Pi and about the robot's devices.

    robot: None checks only the Pi.
    section: the name of the section in the robot's file that lists the devices' drivers and pins.
    root: the root of the file system.
    """
    if not is_raspberry_pi(root):
        remedy = "Run robotcore doctor on the robot; at the desk, --backend virtualpi needs no pins"
        yield Finding.warning(
            "board", "this is no Raspberry Pi: its pins and cameras are not checked", remedy, kind="no-raspberry-pi"
        )
        if robot and section in robot.backends:
            yield from _check_file(robot, section)
        return
    before: list[tuple[str, Check]] = [
        ("board", partial(check_board, root)),
        ("system", partial(check_release, root)),
        ("pin factory", check_library),
        ("permissions", partial(check_permissions, root)),
        ("killed runs", partial(check_persistence, root)),
    ]
    after: list[tuple[str, Check]] = [
        ("power", partial(check_power, root)),
        ("disk", partial(check_disk, root)),
        ("clock", partial(check_clock, root)),
    ]
    yield from findings_of([*before, ("robot", partial(check_devices, root, robot, section)), *after])


def check_devices(root: Path, robot: RobotDescription | None, section: str) -> Iterator[Finding]:
    """Check the robot's file, and check that its devices are present. Without a robot, yield a warning."""
    if robot is None:
        yield Finding.warning(
            "robot",
            "no robot was named, so no devices are checked",
            "Name the robot: robotcore doctor --robot FILE.toml",
            kind="no-robot",
        )
        return
    bindings = yield from _check_file(robot, section)
    if bindings is not None:
        yield from findings_of(_checks(root, bindings))


def _check_file(robot: RobotDescription, section: str) -> Generator[Finding, None, Sequence[DeviceBinding] | None]:
    return check_description(robot, partial(bind_devices, robot, section, None, resolve_pins), count_wires)


def _checks(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[tuple[str, Check]]:
    yield "pins", partial(check_pins, bindings)
    yield "I2C", partial(check_bus, root, bindings)
    yield "serial", partial(check_serial, root, bindings)
    yield "camera", partial(check_cameras, root, bindings)
    if any("picamera2" in binding.driver.modules for binding in bindings):
        yield "picamera2", check_picamera2

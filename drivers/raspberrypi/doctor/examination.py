"""All checks of the doctor in their order: the board, the robot's devices, power, disk and clock."""

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
from drivers.raspberrypi.header import count_wires, on_header
from robotcore.description import RobotDescription
from robotcore.hal.finding import Check, Finding, findings_of
from robotcore.hardware import DeviceBinding, bind_devices
from robotcore.hardware.diagnosis import check_description

ROOT = Path("/")


def examine(robot: RobotDescription | None, section: str, root: Path = ROOT) -> Iterator[Finding]:
    """Yield what is right and what is wrong with this Pi, and with the robot's devices on it where there is a robot."""
    if not is_raspberry_pi(root):
        remedy = "Run robotcore doctor on the robot; at the desk, --backend virtualpi needs no pins"
        yield Finding.warning(
            "board", "this is no Raspberry Pi: its pins and cameras are not looked at", remedy, kind="no-raspberry-pi"
        )
        if robot and section in robot.backends:
            yield from _described(robot, section)
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
    yield from findings_of([*before, ("robot", partial(devices, root, robot, section)), *after])


def devices(root: Path, robot: RobotDescription | None, section: str) -> Iterator[Finding]:
    """Look whether what the robot's file says of its devices can be, and whether they are there."""
    if robot is None:
        yield Finding.warning(
            "robot", "its devices are not looked at", "Name it: robotcore doctor --robot FILE.toml", kind="no-robot"
        )
        return
    fittings = yield from _described(robot, section)
    if fittings is not None:
        yield from findings_of(_checks(root, fittings))


def _described(robot: RobotDescription, section: str) -> Generator[Finding, None, Sequence[DeviceBinding] | None]:
    return check_description(robot, partial(bind_devices, robot, section, None, on_header), count_wires)


def _checks(root: Path, fittings: Iterable[DeviceBinding]) -> Iterator[tuple[str, Check]]:
    yield "pins", partial(check_pins, fittings)
    yield "I2C", partial(check_bus, root, fittings)
    yield "serial", partial(check_serial, root, fittings)
    yield "camera", partial(check_cameras, root, fittings)
    if any("picamera2" in fitting.driver.modules for fitting in fittings):
        yield "picamera2", check_picamera2

"""All that is looked at, in the order in which it is told: the board, the robot's devices, what a run leans on."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from drivers.raspberrypi.doctor.board import board, is_raspberry_pi
from drivers.raspberrypi.doctor.bus import bus
from drivers.raspberrypi.doctor.camera import camera, picamera2
from drivers.raspberrypi.doctor.clock import clock
from drivers.raspberrypi.doctor.disk import disk
from drivers.raspberrypi.doctor.library import library
from drivers.raspberrypi.doctor.permissions import permissions
from drivers.raspberrypi.doctor.persistence import persistence
from drivers.raspberrypi.doctor.pins import pins
from drivers.raspberrypi.doctor.power import power
from drivers.raspberrypi.doctor.release import release
from drivers.raspberrypi.doctor.serial import serial
from drivers.raspberrypi.gpio import on_header
from drivers.raspberrypi.header import counted
from robotcore.description import RobotDescription
from robotcore.hal.finding import Check, Finding, findings_of
from robotcore.hardware import Fitting, fit
from robotcore.hardware.diagnosis import described

ROOT = Path("/")


def examine(robot: RobotDescription | None, section: str, root: Path = ROOT) -> Iterator[Finding]:
    """Yield what is right and what is wrong with this Pi, and with the robot's devices on it where there is a robot."""
    if not is_raspberry_pi(root):
        remedy = "Run robotcore doctor on the robot; at the desk, --backend virtualpi needs no pins"
        yield Finding.warning("board", "this is no Raspberry Pi: its pins and cameras are not looked at", remedy)
        if robot and section in robot.backends:
            yield from _described(robot, section)
        return
    before: list[tuple[str, Check]] = [
        ("board", partial(board, root)),
        ("system", partial(release, root)),
        ("pin factory", library),
        ("permissions", partial(permissions, root)),
        ("killed runs", partial(persistence, root)),
    ]
    after: list[tuple[str, Check]] = [
        ("power", partial(power, root)),
        ("disk", partial(disk, root)),
        ("clock", partial(clock, root)),
    ]
    yield from findings_of([*before, ("robot", partial(devices, root, robot, section)), *after])


def devices(root: Path, robot: RobotDescription | None, section: str) -> Iterator[Finding]:
    """Look whether what the robot's file says of its devices can be, and whether they are there."""
    if robot is None:
        yield Finding.warning("robot", "its devices are not looked at", "Name it: robotcore doctor --robot FILE.toml")
        return
    fittings = yield from _described(robot, section)
    if fittings is not None:
        yield from findings_of(_checks(root, fittings))


def _described(robot: RobotDescription, section: str) -> Generator[Finding, None, Sequence[Fitting] | None]:
    return described(robot, partial(fit, robot, section, None, on_header), counted)


def _checks(root: Path, fittings: Iterable[Fitting]) -> Iterator[tuple[str, Check]]:
    yield "pins", partial(pins, fittings)
    yield "I2C", partial(bus, root, fittings)
    yield "serial", partial(serial, root, fittings)
    yield "camera", partial(camera, root, fittings)
    if any("picamera2" in fitting.driver.modules for fitting in fittings):
        yield "picamera2", picamera2

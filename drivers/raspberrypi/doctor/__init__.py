"""The checks of `robotcore doctor` on a Raspberry Pi.

The parameter ``root`` of a check is the root of the file system. Tests pass a folder with the files of a board.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from drivers.raspberrypi.doctor.devices import (
    check_bus,
    check_cameras,
    check_gamepads,
    check_permissions,
    check_picamera2,
    check_pins,
    check_pwm_chips,
    check_serial,
)
from drivers.raspberrypi.doctor.system import (
    check_board,
    check_clock,
    check_disk,
    check_library,
    check_persistence,
    check_power,
    check_release,
    is_raspberry_pi,
)
from robotcore.description import RobotDescription
from robotcore.hal.check_finding import Check, Finding, findings_of
from robotcore.hardware import DeviceBinding, HardwareBackend
from robotcore.hardware.diagnosis import check_description

__all__ = ["examine", "is_raspberry_pi"]


def examine(backend: HardwareBackend, robot: RobotDescription | None, root: Path = Path("/")) -> Iterator[Finding]:
    """Yield the findings about this Pi and about the robot's devices.

    robot: None checks only the Pi.
    root: the root of the file system.
    """
    if not is_raspberry_pi(root):
        remedy = "Run robotcore doctor on the robot; at the desk, --backend virtualpi needs no pins"
        yield Finding.warning(
            "board", "this is no Raspberry Pi: its pins and cameras are not checked", remedy, kind="no-raspberry-pi"
        )
        if robot and backend.section in robot.backends:
            yield from _check_file(backend, robot)
        return
    yield from findings_of(
        [
            ("board", partial(check_board, root)),
            ("system", check_release),
            ("pin factory", check_library),
            ("permissions", partial(check_permissions, root)),
            ("killed runs", partial(check_persistence, root)),
            ("robot", partial(_check_devices, root, backend, robot)),
            ("power", partial(check_power, root)),
            ("disk", partial(check_disk, root)),
            ("clock", partial(check_clock, root)),
        ]
    )


def _check_devices(root: Path, backend: HardwareBackend, robot: RobotDescription | None) -> Iterator[Finding]:
    if robot is None:
        message, remedy = "no robot was named, so no devices are checked", "robotcore doctor --robot FILE.toml"
        yield Finding.warning("robot", message, f"Name the robot: {remedy}", kind="no-robot")
        return
    bindings = yield from _check_file(backend, robot)
    if bindings is not None:
        yield from findings_of(_list_checks(root, bindings))


def _check_file(
    backend: HardwareBackend, robot: RobotDescription
) -> Generator[Finding, None, Sequence[DeviceBinding] | None]:
    return check_description(robot, partial(backend.bind, robot), backend.summarize)


def _list_checks(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[tuple[str, Check]]:
    yield "pins", partial(check_pins, bindings)
    yield "I2C", partial(check_bus, root, bindings)
    yield "I2C", partial(check_pwm_chips, root, bindings)
    yield "serial", partial(check_serial, root, bindings)
    yield "camera", partial(check_cameras, root, bindings)
    yield "gamepad", partial(check_gamepads, bindings)
    if any("picamera2" in binding.driver.modules for binding in bindings):
        yield "picamera2", check_picamera2

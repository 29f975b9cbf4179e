"""Open the devices of a robot and build the robot from them. If one device fails, none stays open."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from types import MappingProxyType
from typing import Any

from robotcore.description import (
    BatteryDescription,
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    RangeSensorDescription,
    RobotDescription,
)
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device, MemoryDisplay
from robotcore.hal.robot import Robot
from robotcore.hal.truth import TruthSource
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware.binding import bind_devices
from robotcore.hardware.driver import DeviceBinding, Host

_ORDER = (EncoderDescription, RangeSensorDescription, CameraDescription, DisplayDescription, BatteryDescription)


def open_robot(
    setup: Setup,
    section: str,
    clock: Clock,
    *,
    pins: Any = None,
    release: Callable[[], None] = lambda: None,
    truth: TruthSource | None = None,
    opened: Mapping[str, Device] = MappingProxyType({}),
) -> Robot:
    """Open the devices of a robot, and return the robot.

    A display without a table in the section becomes a `MemoryDisplay`. A battery that cannot be opened is left out, and
    the robot gets a note. When the robot is closed, or if opening fails, the devices are closed first, then their
    shared resources. Then ``release`` is called.

    section: the name of the backend's section of the robot's file.
    pins: gpiozero's pin factory; None if the backend has no pins.
    release: closes the backend's own resources.
    truth: the source of the ground truth of a simulated robot.
    opened: the devices that are open already, by name.
    Raises the errors of `bind_devices` and `open_devices`.
    """
    opened = dict(opened)
    host = Host(setup.robot, clock, pins, opened)
    with ExitStack() as undo:
        beneath = undo.enter_context(ExitStack())
        beneath.callback(release)
        beneath.callback(host.shared.close)
        bindings = bind_devices(setup.robot, section, setup.devices - opened.keys())
        notes = open_devices(bindings, host, opened)
        for device in opened.values():
            undo.callback(device.close)
        devices = _in_order(setup, opened)
        cutoffs = [cutoff for binding in bindings for cutoff in binding.cutoffs(host)]
        robot = Robot(
            setup.robot.name, clock, devices, truth=truth, release=beneath.close, cutoffs=cutoffs, notes=notes
        )
        undo.pop_all()
    return robot


def static_cutoffs(robot: RobotDescription, bindings: Iterable[DeviceBinding]) -> tuple[CutoffSpec, ...]:
    """Return the cutoffs of devices that are not open in this process, for `Backend.cutoffs`."""
    host = Host(robot, MonotonicClock(), owner=None)
    return tuple(cutoff for binding in bindings for cutoff in binding.cutoffs(host))


def open_devices(bindings: Iterable[DeviceBinding], host: Host, opened: dict[str, Device]) -> Sequence[str]:
    """Open all devices, motors last, and add them to ``opened``; return a note for each battery that failed.

    If a device other than a battery fails, the remaining devices are opened too, to find all errors. Then all devices
    are closed. One failure is raised as a DeviceError, several failures as a DeviceGroupError, which includes failures
    of closing. ``opened`` must be the same object as ``host.opened``.
    """
    failures: list[Exception] = []
    notes = []
    with ExitStack() as undo:
        for binding in sorted(bindings, key=_rank):
            try:
                device = binding.open(host)
            except DeviceError as failure:
                if isinstance(binding.description, BatteryDescription):
                    notes.append(f"{failure}. Its voltage will not be reported")
                else:
                    failures.append(failure)
                continue
            undo.callback(_close, device, failures)
            opened[binding.name] = device
        if not failures:
            undo.pop_all()
    if len(failures) == 1:
        raise failures[0]
    if failures:
        raise DeviceGroupError(f"opening {host.robot.name}", failures)
    return notes


def _in_order(setup: Setup, opened: Mapping[str, Device]) -> Iterator[Device]:
    """Yield the devices in the order of the robot's file, with a `MemoryDisplay` for each display that is not open."""
    for description in setup.chosen_devices:
        if description.name in opened:
            yield opened[description.name]
        elif isinstance(description, DisplayDescription):
            yield MemoryDisplay(description.name)


def _close(device: Device, failures: list[Exception]) -> None:
    try:
        device.close()
    except Exception as failure:  # noqa: BLE001  all failures are raised together
        failures.append(failure)


def _rank(binding: DeviceBinding) -> int:
    return next((rank for rank, kind in enumerate(_ORDER) if isinstance(binding.description, kind)), len(_ORDER))


def encoder_of(motor: str, robot: RobotDescription) -> str | None:
    """Return the name of the encoder on a motor's wheel; None if the wheel has no encoder."""
    return _encoders(robot).get(motor)


def motor_of(encoder: str, robot: RobotDescription) -> str | None:
    """Return the name of the motor on an encoder's wheel; None if the encoder is on no wheel of the drive."""
    return next((motor for motor, its in _encoders(robot).items() if its == encoder), None)


def _encoders(robot: RobotDescription) -> dict[str, str | None]:
    if (drive := robot.drive) is None:
        return {}
    return {drive.left: drive.left_encoder, drive.right: drive.right_encoder}

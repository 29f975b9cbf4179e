"""Opens the devices of a robot with their drivers. If one device fails, none stays open."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from types import MappingProxyType
from typing import Any

from robotcore.description import DeviceDescription, RobotDescription
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock
from robotcore.hal.device import Actuator, Device, Sensor
from robotcore.hal.kind import build_actuator, is_monitored, load_kind
from robotcore.hal.robot import Robot
from robotcore.hal.truth import TruthSource
from robotcore.hardware.driver import DeviceBinding, DeviceContext
from robotcore.kinds.motor import Motor


def open_robot(
    setup: Setup,
    bindings: Iterable[DeviceBinding],
    clock: Clock,
    *,
    pins: Any = None,
    release: Callable[[], None] = lambda: None,
    truth: TruthSource | None = None,
    opened: Mapping[str, Device] = MappingProxyType({}),
    notes: Iterable[str] = (),
) -> Robot:
    """Open the devices of a robot with their drivers, and return the robot.

    An actuator of an optional kind, such as a display, takes commands without a table in the section too. A monitored
    sensor, such as a battery, that cannot be opened is left out, and the robot gets a note about it. If opening fails,
    and when the robot is closed, the devices are closed, then their shared resources, and then ``release`` is called.

    bindings: the devices with their drivers.
    pins: gpiozero's pin factory; None if the backend has no pins.
    release: closes the backend's own resources.
    truth: the source of the true state of a simulated robot.
    opened: the devices that are open already, by name, which need no driver.
    notes: sentences for the user of a run.

    Raises the errors of `open_devices`.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.backend import Setup
    >>> from robotcore.hal.clock import SteppedClock
    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.hardware import DeviceBinding, DeviceDriver
    >>> from robotcore.kinds.range_sensor import Range, RangeSensorDescription
    >>> class Still(DeviceDriver):
    ...     name, summary, described = "still", "a sensor that always measures 0.5 m", RangeSensorDescription
    ...
    ...     def open(self, description, context):
    ...         return build_sensor(description, lambda: Range(0.5, 0.0, 0))
    >>> setup = Setup(load_robot("rover"), None, devices=frozenset({"nose"}))
    >>> binding = DeviceBinding(setup.robot.first_of("range_sensor"), Still())
    >>> with open_robot(setup, [binding], SteppedClock(20, lambda steps: None)) as robot:
    ...     robot.range.read()
    Range 0.50 m at 0.00 s
    """
    opened = dict(opened)
    host = DeviceContext(setup.robot, clock, pins, opened)
    with ExitStack() as undo:
        resources = undo.enter_context(ExitStack())
        resources.callback(release)
        resources.callback(host.shared.close)
        bindings = [binding for binding in bindings if binding.name not in opened]
        notes = [*notes, *open_devices(bindings, host, opened)]
        for device in opened.values():
            undo.callback(device.close)
        devices = _in_order(setup, opened)
        cutoffs = [each for binding in bindings for each in binding.driver.cutoffs(binding.description, host)]
        robot = Robot(
            setup.robot.name, clock, devices, truth=truth, release=resources.close, cutoffs=cutoffs, notes=notes
        )
        undo.pop_all()
    return robot


def open_devices(bindings: Iterable[DeviceBinding], context: DeviceContext, opened: dict[str, Device]) -> Sequence[str]:
    """Open all devices, the sensors first and the motors last, and add them to ``opened``.

    Return a note for each monitored sensor that failed.

    If another device fails, the remaining devices are still opened, to find all failures. Then all devices are closed.
    Raises one failure as a DeviceError, and several failures, also those of closing, as a DeviceGroupError.

    bindings: the devices with their drivers.
    context: the robot, its clock and the shared resources.
    opened: the same object as ``context.opened``.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.clock import SteppedClock
    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.hardware import DeviceBinding, DeviceContext, DeviceDriver
    >>> from robotcore.kinds.range_sensor import Range, RangeSensorDescription
    >>> class Still(DeviceDriver):
    ...     name, summary, described = "still", "a sensor that always measures 0.5 m", RangeSensorDescription
    ...
    ...     def open(self, description, context):
    ...         return build_sensor(description, lambda: Range(0.5, 0.0, 0))
    >>> opened = {}
    >>> context = DeviceContext(load_robot("rover"), SteppedClock(20, lambda steps: None), opened=opened)
    >>> open_devices([DeviceBinding(context.robot.first_of("range_sensor"), Still())], context, opened)  # notes
    []
    >>> opened["nose"].read()
    Range 0.50 m at 0.00 s
    """
    failures: list[Exception] = []
    notes = []
    with ExitStack() as undo:
        for binding in sorted(bindings, key=_rank):
            try:
                device = binding.open(context)
            except DeviceError as failure:
                if is_monitored(binding.description):
                    notes.append(f"{failure}. The run does not read this {binding.description.kind.replace('_', ' ')}")
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
        raise DeviceGroupError(f"opening {context.robot.name}", failures)
    return notes


def _in_order(setup: Setup, opened: Mapping[str, Device]) -> Iterator[Device]:
    for description in setup.chosen_devices:
        if description.name in opened:
            yield opened[description.name]
        elif issubclass(_class_of(description), Actuator):
            yield build_actuator(description, lambda _command: None)


def _rank(binding: DeviceBinding) -> tuple[bool, bool]:
    device = _class_of(binding.description)
    return not issubclass(device, Sensor), issubclass(device, Motor)


def _class_of(description: DeviceDescription) -> type[Device]:
    return load_kind(description.kind).device


def _close(device: Device, failures: list[Exception]) -> None:
    try:
        device.close()
    except Exception as failure:  # noqa: BLE001  all failures are raised together
        failures.append(failure)


def encoder_of(motor: str, robot: RobotDescription) -> str | None:
    """Return the name of the encoder on a motor's wheel, or None if the wheel has no encoder.

    motor: the name of the motor.
    robot: the description of the robot.

    >>> from robotcore.description import load_robot
    >>> encoder_of("left_motor", load_robot("rover"))
    'left_encoder'
    """
    return _encoders(robot).get(motor)


def motor_of(encoder: str, robot: RobotDescription) -> str | None:
    """Return the name of the motor on an encoder's wheel, or None if the encoder is on no wheel of the drive.

    encoder: the name of the encoder.
    robot: the description of the robot.

    >>> from robotcore.description import load_robot
    >>> motor_of("left_encoder", load_robot("rover"))
    'left_motor'
    """
    return next((motor for motor, its in _encoders(robot).items() if its == encoder), None)


def _encoders(robot: RobotDescription) -> dict[str, str | None]:
    if (drive := robot.drive) is None:
        return {}
    return {motor: name for name, motor in drive.motor_by_device.items() if name in drive.encoders}

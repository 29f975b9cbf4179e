"""The simulated hardware of a virtual Pi: by the robot's own file, or by the file of the true robot."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from drivers.raspberrypi.virtual.models import describe_hardware
from robotcore.description import DeviceDescription, RobotDescription, load_robot
from robotcore.errors import DeviceError, DeviceGroupError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.device import Device, Sensor
from robotcore.hal.kind import build_actuator, build_sensor, load_kind
from robotcore.hardware import DeviceBinding, bind_devices, list_drivers

PICTURE_KEYS = {"camera": ("width_px", "height_px"), "lidar": ("count",)}
"""The keys of a description that a driver sets in the sensor, by kind. The robot's own file gives them."""


@dataclass(frozen=True)
class Hardware:
    """The simulated robot, and the wires between its devices and the pins."""

    robot: RobotDescription
    devices: frozenset[str]
    """The names of the devices to simulate."""
    bindings: tuple[DeviceBinding, ...]
    """The wired devices, with the drivers whose settings name the pins."""


def describe_own_hardware(setup: Setup, bindings: Collection[DeviceBinding]) -> Hardware:
    """Return the hardware of a robot that is as its own file describes it."""
    return Hardware(_replace_devices(setup.robot, bindings), setup.devices, tuple(bindings))


def load_true_hardware(setup: Setup, truth: str, section: str, simulated: Collection[str]) -> Hardware:
    """Return the hardware that the file of the true robot describes.

    A device without a table in the section is not connected, so it is left out.

    truth: the file of the true robot.
    section: the section of the backend in both files.
    simulated: the names of the true robot's devices that the simulator has.

    Raises UsageError if the file cannot be read or describes another kind of robot, and DescriptionError for mistakes
    in it.
    """
    robot = load_truth(truth, section, setup.robot)
    if setup.is_ideal:
        robot = robot.idealise()
    if setup.world:
        robot = robot.with_conditions(setup.world.conditions)
    bindings = bind_devices(robot, section, robot.backends[section].keys())
    devices = frozenset(each.name for each in robot.devices if _is_connected(each, robot.backends[section]))
    own = {each.name: each for each in setup.robot.devices}
    robot = _replace_devices(robot, bindings)
    fitted = (_set_picture_size(each, own.get(each.name)) for each in robot.devices)
    return Hardware(robot.model_copy(update={"devices": tuple(fitted)}), devices & frozenset(simulated), bindings)


def load_truth(truth: str, section: str, own: RobotDescription) -> RobotDescription:
    """Return the description of the true robot, after a check that the user's description is one of the same robot.

    own: the user's description.

    Raises UsageError and DescriptionError as `load_true_hardware`.
    """
    robot = load_robot(truth)
    if section not in robot.backends:
        raise UsageError(
            f"option truth: {robot.source} has no section [{section}], which connects the true devices to pins. Copy "
            f"the robot's own file, {own.source}, and change the values that are wrong",
            kind="truth-without-section",
            section=section,
        )
    if (robot.drive is None) != (own.drive is None):
        without = robot if robot.drive is None else own
        raise UsageError(
            f"option truth: {without.source} has no [drive], but the file of the same robot has one. Add it",
            kind="truth-with-other-drive",
        )
    kinds = {each.name: each.kind for each in robot.devices}
    for each in own.devices:
        if kinds.get(each.name, each.kind) != each.kind:
            raise UsageError(
                f"option truth: {each.name!r} is of the kind {kinds[each.name]!r} in {robot.source}, but of the kind "
                f"{each.kind!r} in {own.source}. Give both the same kind, or another name",
                kind="truth-of-other-kind",
                device=each.name,
            )
    return robot


def adopt_devices(own: Mapping[str, DeviceDescription], simulated: Mapping[str, Device]) -> Iterator[Device]:
    """Yield devices that measure and act as the true ones, with the properties of the user's descriptions.

    own: the user's descriptions by name.
    simulated: the devices of the simulated true robot by name.

    Raises DeviceError for a device that the true robot lacks, and DeviceGroupError for several. A device of an optional
    kind is left out.
    """
    problem = "is not connected to the true robot. Add it with its table to that file, or remove it from this one"
    lost = []
    for name, description in own.items():
        if name in simulated:
            yield _adopt(description, simulated[name])
        elif not load_kind(description.kind).is_optional:
            lost.append(DeviceError(name, problem, kind="not-connected"))
    if lost:
        raise lost[0] if len(lost) == 1 else DeviceGroupError("opening the true robot", lost)


def _adopt(description: DeviceDescription, device: Device) -> Device:
    true: Any = device
    if not isinstance(device, Sensor):
        return build_actuator(description, true.send, true.close)
    sensor = build_sensor(description, lambda: sensor.limit_sample(true.read()), true.close)
    return sensor


def _replace_devices(robot: RobotDescription, bindings: Collection[DeviceBinding]) -> RobotDescription:
    hardware = {binding.name: describe_hardware(binding) for binding in bindings}
    return robot.model_copy(update={"devices": tuple(hardware.get(each.name, each) for each in robot.devices)})


def _set_picture_size(true: DeviceDescription, own: DeviceDescription | None) -> DeviceDescription:
    keys = PICTURE_KEYS.get(true.kind, ())
    return true.model_copy(update={key: getattr(own, key) for key in keys}) if own else true


def _is_connected(device: DeviceDescription, tables: Mapping[str, Any]) -> bool:
    return device.name in tables or load_kind(device.kind).is_optional or not list_drivers(type(device))

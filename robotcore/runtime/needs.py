"""The devices that an app needs: by role, by name, or by the class of their kind."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.hal.backend import Backend
from robotcore.hal.device import Device
from robotcore.hal.kind import list_monitored, load_kind
from robotcore.hal.robot import Role
from robotcore.plugins import kind_names
from robotcore.text import suggestion

Need = Role | str | type[Device]
"""A role, the name of a device in the robot's file, or the class of a kind, such as Camera."""


def needed_devices(description: RobotDescription, needs: Iterable[Need], wants: Iterable[Need] = ()) -> frozenset[str]:
    """Return the names of the devices that a run opens for an app.

    A servo on which one of them is mounted is opened too.

    needs: what the app requires. A class stands for all devices of its kind. The role of the drive includes its motors,
        its encoders, and the sensors that measure the distance ahead.
    wants: what the app uses if the robot has it.

    Raises UnmetNeedError if the robot lacks something that the app requires, and UsageError for a wrong need.
    """
    declared: dict[str, Any] = {"needs": needs, "wants": wants}
    for attribute, value in declared.items():
        if isinstance(value, (str, type)) or not isinstance(value, Collection):
            example = format_need(value if isinstance(value, (str, type)) else Role.DRIVE)
            text = f"{attribute} is {format_need(value)}. Write a set: {attribute} = {{{example}}}"
            raise UsageError(text, kind="needs-not-a-set")
    names: set[str] = set()
    for need in sorted(needs, key=format_need):
        found = find_devices(description, need)
        if not found:
            raise _build_unmet_error(description, need)
        names |= found
    names = names.union(*(find_devices(description, want) for want in wants))
    return frozenset(names.union(*(description.list_carriers(name) for name in names)))


def choose_devices(
    backend: Backend,
    description: RobotDescription,
    options: Mapping[str, Any],
    needs: Iterable[Need],
    wants: Iterable[Need] = (),
    *,
    remedy: str = "Choose another --backend",
) -> frozenset[str]:
    """Return the names of the devices that a run opens: those of the app that the backend has, and the monitored ones.

    options: the user's options for the backend.
    needs, wants: those of the app.
    remedy: what to do if the backend lacks a device that the app needs.

    Raises UsageError if the backend lacks such a device, and the errors of `needed_devices`.
    """
    openable = backend.openable(description, options)
    if missing := needed_devices(description, needs) - openable:
        kinds = {device.name: device.kind.replace("_", " ") for device in description.devices}
        name = min(missing)
        other = "move the device from the app's needs to its wants"
        if name in {sensor.name for sensor in description.sensors_ahead}:
            other = "a robot without it: the range guard reads it, because it looks ahead"
        raise UsageError(
            f"the backend {backend.name!r} cannot open the {kinds[name]} {name!r}. {remedy}, or {other}",
            kind="device-not-openable",
            device=name,
        )
    return openable & (needed_devices(description, needs, wants) | list_monitored(description))


def find_devices(description: RobotDescription, need: Need) -> frozenset[str]:
    """Return the names of the devices that a need stands for; none if the robot lacks it.

    A text is the name of a device, or else the name of a role.
    """
    if isinstance(need, type) and issubclass(need, Device) and need.kind:
        return frozenset(each.name for each in description.devices if issubclass(load_kind(each.kind).device, need))
    if isinstance(need, str) and not isinstance(need, Role):
        if any(device.name == need for device in description.devices):
            return frozenset({need})
        if need not in [role.value for role in Role]:
            return frozenset()
        need = Role(need)
    if not isinstance(need, Role):
        written = format_need(need)
        raise UsageError(
            f"the need {written} is neither a role, nor the name of a device, nor the class of a kind. Write one, such "
            f"as {format_need(Role.CAMERA)}, 'lamp' or Bumper",
            kind="wrong-need",
        )
    if need is not Role.DRIVE:
        return frozenset(device.name for device in description.all_of(need.kind)[:1])
    if (drive := description.drive) is None:
        return frozenset()
    ahead = {sensor.name for sensor in description.sensors_ahead}
    return frozenset({*drive.motors, *drive.encoders, *filter(None, (drive.steering_servo,))} | ahead)


def require_turn_on_spot(description: RobotDescription) -> None:
    """Raise UsageError if the robot cannot turn on the spot."""
    if radius := description.min_turn_radius_m:
        raise UsageError(
            f"the app turns on the spot, but {description.name!r} steers: the radius of its sharpest turn is "
            f"{radius:.2f} m. Choose another robot",
            kind="no-turn-on-spot",
            radius_m=radius,
        )


def name_need(need: Need) -> str:
    """Return the name of a need: of a role, a kind or a device."""
    if isinstance(need, Role):
        return need.value
    return need.kind if isinstance(need, type) else need


def format_need(need: Need) -> str:
    """Return a need as an app's file has it, such as ``Role.CAMERA``, ``'gripper'`` or ``Camera``."""
    if isinstance(need, Role):
        return f"Role.{need.name}"
    return need.__name__ if isinstance(need, type) else repr(need)


def _build_unmet_error(description: RobotDescription, need: Need) -> UnmetNeedError:
    advice = "Choose another --robot, or add"
    if need in [role.value for role in Role]:
        need = Role(need)
    if isinstance(need, Role):
        table = f'[[devices]] with kind = "{need.kind}"' if need.kind else "[drive]"
        lacking, remedy = need.value, f"{advice} {table}"
    elif isinstance(need, type):
        kinds = ", ".join(sorted({device.kind for device in description.devices}))
        lacking = need.kind.replace("_", " ")
        remedy = f'Its kinds of device are: {kinds}. {advice} [[devices]] with kind = "{need.kind}"'
    else:
        roles = (role.value for role in Role if find_devices(description, role))
        found = _suggest_class(need) or suggestion(need, [*(device.name for device in description.devices), *roles])
        lacking, remedy = f"device {need!r}", f'{found} {advice} [[devices]] with name = "{need}"'
    return UnmetNeedError(f"the robot {description.name!r} has no {lacking}, which the app needs. {remedy}")


def _suggest_class(name: str) -> str:
    """Return the advice to write the class of a kind, if the name is that of a kind; else ``""``."""
    if (kind := name.lower()) not in kind_names():
        return ""
    device = load_kind(kind).device
    return f"If the app needs the kind {kind!r}, write the class {device.__name__} of {device.__module__}."

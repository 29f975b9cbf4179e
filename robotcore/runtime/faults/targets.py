"""What of a robot can fail: its devices by name, its roles, its loop, its connection."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from robotcore.description import RobotDescription
from robotcore.errors import UnknownNameError, UsageError
from robotcore.runtime.faults.fault import Kind

_KINDS = {
    "camera": Kind.CAMERA,
    "range_sensor": Kind.RANGE,
    "encoder": Kind.ENCODER,
    "battery": Kind.BATTERY,
    "motor": Kind.MOTOR,
    "display": Kind.DISPLAY,
}
"""By the kinds of a description."""

_FIRST_OF = {"camera": Kind.CAMERA, "range": Kind.RANGE, "battery": Kind.BATTERY, "display": Kind.DISPLAY}

ROLES = {
    Kind.CAMERA: "camera",
    Kind.RANGE: "range",
    Kind.ENCODER: "encoders",
    Kind.BATTERY: "battery",
    Kind.MOTOR: "drive",
    Kind.DISPLAY: "display",
    Kind.LOOP: "loop",
    Kind.CONNECTION: "connection",
}
"""The target that every robot has which has something of the kind."""


class Target(NamedTuple):
    """Devices of one kind that fail together; none of a loop, all of a connection."""

    kind: Kind
    devices: frozenset[str]


def find_target(name: str, description: RobotDescription, opened: Collection[str]) -> Target:
    """Return what fails where a spec has this target; UsageError where there is none in a run that opens these."""
    targets = targets_of(description, opened)
    if name in targets:
        return targets[name]
    if name in targets_of(description, [device.name for device in description.devices]):
        raise UsageError(f"the app opens no {name}; what it opens that can fail: {', '.join(sorted(targets))}")
    raise UnknownNameError("target", name, list(targets))


def targets_of(description: RobotDescription, opened: Collection[str]) -> dict[str, Target]:
    """Return what can fail of a robot whose devices of these names are open, by what it is called in a spec."""
    devices = {each.name: _KINDS[each.kind] for each in description.devices if each.name in opened}
    return {
        "loop": Target(Kind.LOOP, frozenset()),
        "connection": Target(Kind.CONNECTION, frozenset(devices)),
        **_roles(description, devices),
        **{name: Target(kind, frozenset({name})) for name, kind in devices.items()},
    }


def _roles(description: RobotDescription, devices: dict[str, Kind]) -> dict[str, Target]:
    filled = {role: [name for name in devices if devices[name] is kind][:1] for role, kind in _FIRST_OF.items()}
    if drive := description.drive:
        filled["drive"] = _open((drive.left, drive.right), devices)
        filled["encoders"] = _open((drive.left_encoder, drive.right_encoder), devices)
    return {role: Target(devices[names[0]], frozenset(names)) for role, names in filled.items() if names}


def _open(names: Iterable[str | None], devices: dict[str, Kind]) -> list[str]:
    return [name for name in names if name in devices]

"""The targets of faults: devices by their name, their role or their kind, the loop, and the connection."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import ClassVar, NamedTuple

from robotcore.description import RobotDescription
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.device import Device
from robotcore.hal.kind import load_kind
from robotcore.hal.robot import Role
from robotcore.plugins import kind_names


class LoopTarget:
    """The class of the target ``loop``.

    >>> from robotcore.description import load_robot
    >>> from robotcore.runtime.faults.targets import find_target
    >>> find_target("loop", load_robot("rover"), opened=[]).kind is LoopTarget
    True
    """

    kind: ClassVar[str] = "loop"


class ConnectionTarget:
    """The class of the target ``connection``.

    >>> from robotcore.description import load_robot
    >>> from robotcore.runtime.faults.targets import find_target
    >>> sorted(find_target("connection", load_robot("rover"), opened=["eye", "nose"]).devices)
    ['eye', 'nose']
    """

    kind: ClassVar[str] = "connection"


TargetClass = type[Device] | type[LoopTarget] | type[ConnectionTarget]
"""The class of a target: LoopTarget, ConnectionTarget, or the class of a kind of device."""

_OF_THE_DRIVE = {"motor": "drive", "encoder": "encoders"}
"""For each kind on the wheels of a drive, the name of the target that stands for both."""

_ROLES = {role.kind: role.value for role in Role if role.kind} | _OF_THE_DRIVE


class FaultTarget(NamedTuple):
    """The target of a fault: devices that fail together, the loop, or the connection."""

    kind: TargetClass
    """The class of the target."""
    devices: frozenset[str]
    """The names of the devices. The target ``loop`` has no device, ``connection`` has all devices."""


def name_target(kind: str) -> str:
    """Return the name of the target that stands for devices of a kind: their role, or else the name of the kind.

    >>> name_target("camera"), name_target("encoder"), name_target("bumper")
    ('camera', 'encoders', 'bumper')
    """
    return _ROLES.get(kind, kind)


def list_classes() -> list[TargetClass]:
    """Return the classes of all targets. A kind of device that cannot be loaded is left out."""
    classes: list[TargetClass] = []
    for name in kind_names():
        with suppress(BackendMissingError):
            classes.append(load_kind(name).device)
    return [*classes, LoopTarget, ConnectionTarget]


def find_target(name: str, description: RobotDescription, opened: Collection[str]) -> FaultTarget:
    """Return the target with a name. Raises UsageError if there is no such target.

    opened: the names of the devices that the run opens.
    """
    targets = list_targets(description, opened)
    if name in targets:
        return targets[name]
    if name in list_targets(description, [device.name for device in description.devices]):
        raise UsageError(
            f"the app does not use {name}. Choose a target that it uses: {', '.join(sorted(targets))}",
            kind="fault-target-not-open",
        )
    raise UnknownNameError("target", name, list(targets))


def list_targets(description: RobotDescription, opened: Collection[str]) -> dict[str, FaultTarget]:
    """Return all targets of a robot by name. A role or a kind stands for its first open device.

    opened: the names of the devices that the run opens.
    """
    kinds = {each.name: each.kind for each in description.devices if each.name in opened}
    groups: dict[str, Sequence[str]] = {}
    for name, kind in kinds.items():
        if kind not in _OF_THE_DRIVE:
            groups.setdefault(name_target(kind), [name])
    if drive := description.drive:
        groups |= {"drive": drive.motors, "encoders": drive.encoders}
    open_groups = {group: [name for name in names if name in kinds] for group, names in groups.items()}
    open_groups |= {name: [name] for name in kinds}
    return {
        "loop": FaultTarget(LoopTarget, frozenset()),
        "connection": FaultTarget(ConnectionTarget, frozenset(kinds)),
        **{
            group: FaultTarget(load_kind(kinds[names[0]]).device, frozenset(names))
            for group, names in open_groups.items()
            if names
        },
    }

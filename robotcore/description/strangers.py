"""What a backend's section of a robot's file tells of devices that the robot does not have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from robotcore.description.robot import RobotDescription
from robotcore.errors import nearest


def strangers_in(robot: RobotDescription, table: Mapping[str, Any]) -> dict[str, str | None]:
    """Return the names in a section that no device has, and which device without a section each probably means."""
    names = [device.name for device in robot.devices]
    untold = [name for name in names if name not in table]
    return {name: nearest(name, untold) for name in table if name not in names}


def faults_of_strangers(section: str, strangers: Mapping[str, str | None]) -> Iterator[tuple[str, str, str]]:
    """Yield what to say of each: the key, the fault and the remedy."""
    for name, device in strangers.items():
        remedy = f"Did you mean {device!r}?" if device else "Take the section out, or add [[devices]] of that name"
        yield f"{section}.{name}", "no device has this name", remedy

"""A backend's section of a robot's file: a table for each device, and all that is wrong with them at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from robotcore.description.devices import AnyDevice
from robotcore.description.robot import RobotDescription
from robotcore.description.types import StrictModel
from robotcore.description.validation import MAX_FILE_ERRORS, find_mistakes, limit_errors
from robotcore.errors import nearest

T = TypeVar("T")
DescribedT = TypeVar("DescribedT", bound=StrictModel)

MistakeParts = tuple[str, str, str]
"""The key, what is wrong with it, and the remedy."""


class MistakesError(Exception):
    """What is wrong with one device's table."""

    def __init__(self, *faults: MistakeParts) -> None:
        super().__init__(faults)
        self.faults = faults


def read_each(
    robot: RobotDescription,
    section: str,
    needed: Collection[str],
    read: Callable[[AnyDevice, str, Any], T],
    missing_remedy: Callable[[AnyDevice], str],
) -> tuple[list[T], list[MistakeParts]]:
    """Return what ``read`` makes of each device, its key and its table, and what is wrong with the section.

    ``missing_remedy`` returns the remedy if a device that is ``needed`` has no table. ``read`` raises MistakesError.
    """
    table = robot.backends.get(section, {})
    strangers = _unknown_devices(robot, table)
    made: list[T] = []
    faults = list(_mistakes_of_unknown_devices(section, strangers))
    for device in robot.devices:
        key = f"{section}.{device.name}"
        if device.name in table:
            try:
                made.append(read(device, key, table[device.name]))
            except MistakesError as unfit:
                faults += unfit.faults
        elif device.name in needed and device.name not in strangers.values():
            faults.append((key, "is missing", missing_remedy(device)))
    return made, list(limit_errors(faults))


def validate_table(model: type[DescribedT], key: str, table: Mapping[str, Any]) -> DescribedT:
    """Return a table as the model has it; raises MistakesError with all that is wrong."""
    try:
        return model.model_validate(table, strict=True)
    except ValidationError as error:
        faults = find_mistakes(error, model, table)
        mistakes = ((f"{key}.{fault.key}".rstrip("."), fault.fault, fault.remedy) for fault in faults)
        raise MistakesError(*mistakes) from error


def _unknown_devices(robot: RobotDescription, table: Mapping[str, Any]) -> dict[str, str | None]:
    """Return the names in a section that no device has, and which device without a table each probably means."""
    names = [device.name for device in robot.devices]
    without_table = [name for name in names if name not in table]
    strangers = [name for name in table if name not in names]
    return {
        name: nearest(name, without_table) if number < MAX_FILE_ERRORS else None
        for number, name in enumerate(strangers)
    }


def _mistakes_of_unknown_devices(section: str, strangers: Mapping[str, str | None]) -> Iterator[MistakeParts]:
    for name, device in strangers.items():
        remedy = f"Did you mean {device!r}?" if device else "Take the section out, or add [[devices]] of that name"
        yield f"{section}.{name}", "no device has this name", remedy

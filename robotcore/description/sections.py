"""Reads the tables of devices in a backend's section of a robot's file, and collects the mistakes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from robotcore.description.devices import DeviceDescription
from robotcore.description.robot import RobotDescription
from robotcore.description.types import StrictModel
from robotcore.description.validation import MAX_FILE_ERRORS, find_mistakes, limit_errors
from robotcore.errors import Mistake
from robotcore.text import find_nearest

T = TypeVar("T")
DescribedT = TypeVar("DescribedT", bound=StrictModel)


class MistakesError(Exception):
    """The mistakes in one device's table, if it has several."""

    def __init__(self, *mistakes: Mistake) -> None:
        super().__init__(mistakes)
        self.mistakes = mistakes


def read_each(
    robot: RobotDescription,
    section: str,
    needed: Collection[str],
    read: Callable[[DeviceDescription, Any], T],
    missing_remedy: Callable[[DeviceDescription], str],
) -> tuple[list[T], list[Mistake]]:
    """Read the tables of all devices. Return the results of ``read``, and the mistakes in the section.

    section: the name of the section.
    needed: the names of the devices that must have a table.
    read: a function that reads the table of a device, or raises Mistake or MistakesError with keys within the table.
        Its arguments are the device and the table.
    missing_remedy: a function that returns the remedy for a needed device without a table.
    """
    table = robot.backends.get(section, {})
    unknown = _match_unknown_names(robot, table)
    results: list[T] = []
    mistakes = list(_find_unknown_names(section, unknown))
    for device in robot.devices:
        key = f"{section}.{device.name}"
        if device.name in table:
            try:
                results.append(read(device, table[device.name]))
            except Mistake as mistake:
                mistakes.append(mistake.below(key))
            except MistakesError as error:
                mistakes += (mistake.below(key) for mistake in error.mistakes)
        elif device.name in needed and device.name not in unknown.values():
            mistakes.append(Mistake("is missing", missing_remedy(device), kind="missing-section", key=key))
    return results, [*limit_errors(mistakes)]


def validate_table(model: type[DescribedT], table: Mapping[str, Any]) -> DescribedT:
    """Return the content of a table as an instance of a model. Raises MistakesError with all mistakes in the table."""
    try:
        return model.model_validate(table, strict=True)
    except ValidationError as error:
        raise MistakesError(*find_mistakes(error, model, table)) from error


def _match_unknown_names(robot: RobotDescription, table: Mapping[str, Any]) -> dict[str, str | None]:
    """Return a mapping from each unknown name in a section to the device with a similar name, or to None."""
    names = [device.name for device in robot.devices]
    without_table = [name for name in names if name not in table]
    unknown = [name for name in table if name not in names]
    return {
        name: find_nearest(name, without_table) if number < MAX_FILE_ERRORS else None
        for number, name in enumerate(unknown)
    }


def _find_unknown_names(section: str, unknown: Mapping[str, str | None]) -> Iterator[Mistake]:
    for name, device in unknown.items():
        remedy = f"Did you mean {device!r}?" if device else "Remove the table, or add [[devices]] with this name"
        yield Mistake("no device has this name", remedy, kind="unknown-device", key=f"{section}.{name}")

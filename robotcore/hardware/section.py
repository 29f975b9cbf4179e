"""A backend's section of a robot's file: a driver and its settings for each device."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from robotcore.description import AnyDevice, BatteryDescription, DisplayDescription, RobotDescription
from robotcore.description.faults import LONGEST
from robotcore.description.sections import UnfitError, read_each, validated
from robotcore.errors import DescriptionError, UnknownNameError
from robotcore.hardware.choice import choice, meant
from robotcore.hardware.connections import Connection
from robotcore.hardware.driver import DeviceDriver
from robotcore.hardware.fitting import Fitting
from robotcore.hardware.refusal import refused
from robotcore.hardware.together import at_odds, clashes, misplaced
from robotcore.plugins import DEVICES, load_registered

_OPTIONAL = (BatteryDescription, DisplayDescription)


def batteries_in(robot: RobotDescription, section: str) -> frozenset[str]:
    """Return the names of the batteries that the ``section`` tells of: a backend's answer to `Backend.batteries`."""
    told = robot.backends.get(section, {})
    return frozenset(battery.name for battery in robot.all_of(BatteryDescription) if battery.name in told)


def fit(
    robot: RobotDescription,
    section: str,
    names: Iterable[str] | None = None,
    place: Callable[[Connection], Iterable[Connection]] = lambda _wire: (),
) -> tuple[Fitting, ...]:
    """Return how the devices of those names, by default all, are connected, by a backend's ``section`` of the file.

    A display or a battery that the section does not tell of is left out: a display needs no wires, and not every board
    tells of the battery. ``place`` returns which other places of the board a wire takes, such as a port's pins, and
    raises ValueError, the fault, a semicolon and the remedy, for one that goes to no place of it. Raises
    DescriptionError, with all that is wrong.
    """
    chosen = {device.name for device in robot.devices} if names is None else set(names)
    wired = [told.name for told in robot.devices if told.name in chosen and not isinstance(told, _OPTIONAL)]
    if section not in robot.backends and wired:
        remedy = f"Say how each device is connected, from [{section}.{wired[0]}] on"
        raise DescriptionError(robot.source, section, "is missing", remedy)
    fittings, faults = read_each(robot, section, wired, partial(_fitting, robot), _untold)
    faults += [
        *at_odds(section, fittings, robot),
        *misplaced(section, fittings, place),
        *clashes(section, fittings, place),
    ]
    if faults:
        raise DescriptionError.of_all(robot.source, faults)
    return tuple(fitting for fitting in fittings if fitting.name in chosen)


def _fitting(robot: RobotDescription, told: AnyDevice, key: str, table: Any) -> Fitting:
    driver = _driver(told, key, table)
    settings = validated(driver.settings, key, {name: value for name, value in table.items() if name != "driver"})
    if faults := list(refused(key, partial(driver.check, told, settings, robot))):
        raise UnfitError(*faults)
    return Fitting(told, driver, settings)


def _driver(told: AnyDevice, key: str, table: Any) -> DeviceDriver[Any, Any]:
    if not isinstance(table, Mapping):
        raise UnfitError((key, f"should be a table, got {table!r}", f"Name its driver: {choice(told)}"))
    if "driver" not in table:
        raise UnfitError((f"{key}.driver", "is missing", f"Add it: {choice(told)}"))
    if not isinstance(name := table["driver"], str):
        raise UnfitError((f"{key}.driver", f"should be a name in quotes, got {name!r}", f"Name one: {choice(told)}"))
    try:
        driver: DeviceDriver[Any, Any] = load_registered("device driver", DEVICES, name)()
    except UnknownNameError as unknown:
        fault = f"unknown device driver {name[:LONGEST]!r}"
        raise UnfitError((f"{key}.driver", fault, meant(name, told))) from unknown
    if not isinstance(told, driver.described):
        fault = f"{name!r} opens no {told.kind.replace('_', ' ')}"
        raise UnfitError((f"{key}.driver", fault, f"Name one: {choice(told)}"))
    return driver


def _untold(told: AnyDevice) -> str:
    return (
        f"Say how it is connected, first of all its driver: {choice(told)}; or, where the robot has none, take "
        f"{told.name!r} out of its [[devices]]"
    )

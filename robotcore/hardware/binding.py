"""Bind the devices of a robot's file to drivers and settings, by a backend's section of that file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from robotcore.description import AnyDevice, BatteryDescription, DisplayDescription, RobotDescription
from robotcore.description.sections import MistakeParts, MistakesError, read_each, validate_table
from robotcore.description.validation import MAX_SHOWN_CHARACTERS
from robotcore.errors import BackendMissingError, DescriptionError, UnknownNameError, suggestion
from robotcore.hardware.driver import Connection, DeviceDriver, Fitting
from robotcore.plugins import DEVICES, device_driver_names, load_registered

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
    settings = validate_table(driver.settings, key, {name: value for name, value in table.items() if name != "driver"})
    if faults := list(refused(key, partial(driver.check, told, settings, robot))):
        raise MistakesError(*faults)
    return Fitting(told, driver, settings)


def _driver(told: AnyDevice, key: str, table: Any) -> DeviceDriver[Any, Any]:
    if not isinstance(table, Mapping):
        raise MistakesError((key, f"should be a table, got {table!r}", f"Name its driver: {choice(told)}"))
    if "driver" not in table:
        raise MistakesError((f"{key}.driver", "is missing", f"Add it: {choice(told)}"))
    if not isinstance(name := table["driver"], str):
        raise MistakesError((f"{key}.driver", f"should be a name in quotes, got {name!r}", f"Name one: {choice(told)}"))
    try:
        driver: DeviceDriver[Any, Any] = load_registered("device driver", DEVICES, name)()
    except UnknownNameError as unknown:
        fault = f"unknown device driver {name[:MAX_SHOWN_CHARACTERS]!r}"
        raise MistakesError((f"{key}.driver", fault, meant(name, told))) from unknown
    if not isinstance(told, driver.described):
        fault = f"{name!r} opens no {told.kind.replace('_', ' ')}"
        raise MistakesError((f"{key}.driver", fault, f"Name one: {choice(told)}"))
    return driver


def _untold(told: AnyDevice) -> str:
    return (
        f"Say how it is connected, first of all its driver: {choice(told)}; or, where the robot has none, take "
        f"{told.name!r} out of its [[devices]]"
    )


def choice(told: AnyDevice) -> str:
    """Return the names of the drivers that take such a device."""
    return ", ".join(drivers_of(told)) or "there is none for it"


def meant(name: str, told: AnyDevice) -> str:
    """Return which driver of such a device was probably meant, by its name or by what it drives; or name them all."""
    drivers = drivers_of(told)
    word = _plain(name)
    for driver in drivers:
        if _plain(driver) == word:
            return f"Did you mean {driver!r}?"
    for driver, kind in drivers.items():
        if any(part in word or (len(word) > 2 and word in part) for part in map(_plain, kind.parts)):
            return f"Did you mean {driver!r}?"
    return suggestion(name, list(drivers))


def _plain(word: str) -> str:
    """Return a word as it may be written: ``Pi Camera``, ``pi-camera`` and ``picamera`` are one."""
    return "".join(letter for letter in word.lower() if letter.isalnum())


def drivers_of(told: AnyDevice) -> dict[str, type[DeviceDriver[Any, Any]]]:
    """Return the drivers that take such a device, by their names, of those that can be loaded."""
    found = {}
    for name in device_driver_names():
        with suppress(BackendMissingError):
            driver: type[DeviceDriver[Any, Any]] = load_registered("device driver", DEVICES, name)
            if isinstance(told, driver.described):
                found[name] = driver
    return found


def refused(key: str, check: Callable[[], object]) -> Iterator[MistakeParts]:
    """Yield what a check raises: ValueError, the fault, a semicolon and the remedy."""
    try:
        check()
    except ValueError as error:
        fault, _, remedy = str(error).rpartition("; ")
        yield (key, fault, remedy[:1].upper() + remedy[1:]) if fault else (key, remedy, "Correct it")


def at_odds(section: str, fittings: Sequence[Fitting], robot: RobotDescription) -> Iterator[MistakeParts]:
    """Yield what drivers refuse of what the robot's other devices have as drivers."""
    drivers = {fitting.name: fitting.driver for fitting in fittings}
    for fitting in fittings:
        check = partial(fitting.driver.check_beside, fitting.told, fitting.settings, robot, drivers)
        yield from refused(f"{section}.{fitting.name}", check)


def misplaced(
    section: str, fittings: Iterable[Fitting], place: Callable[[Connection], object]
) -> Iterator[MistakeParts]:
    """Yield what ``place`` refuses: a wire that goes to no place of the board."""
    for fitting in fittings:
        for wire in fitting.connections:
            yield from refused(f"{section}.{fitting.name}.{wire.signal}", partial(place, wire))


def clashes(
    section: str, fittings: Iterable[Fitting], place: Callable[[Connection], Iterable[Connection]]
) -> Iterator[MistakeParts]:
    """Yield every place to which two wires go, of which one would have it alone; `fit` tells of ``place``."""
    taken: dict[tuple[str, str], tuple[str, Connection]] = {}
    for fitting in fittings:
        for wire in _wires(fitting, place):
            key = f"{section}.{fitting.name}.{wire.signal}"
            first, before = taken.setdefault((wire.bus, wire.where), (key, wire))
            if before is not wire and not wire.shares(before):
                yield (
                    key,
                    f"{wire} is already {first}{_spoken(before)}",
                    f"Connect one of them elsewhere{_or(wire, before)}",
                )


def _wires(fitting: Fitting, place: Callable[[Connection], Iterable[Connection]]) -> Iterator[Connection]:
    for wire in fitting.connections:
        yield wire
        with suppress(ValueError):  # what it refuses is told by `misplaced`
            yield from place(wire)


def _spoken(before: Connection) -> str:
    return f", where {before.spoken} is spoken" if before.spoken else ""


def _or(wire: Connection, before: Connection) -> str:
    return f", or {wire.instead}" if wire.instead and wire.signal == before.signal else ""

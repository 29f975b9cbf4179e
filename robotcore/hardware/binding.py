"""Reads the driver and the settings of each device from a backend's section of the robot's file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from robotcore.description import DeviceDescription, RobotDescription
from robotcore.description.sections import read_each, validate_table
from robotcore.description.validation import MAX_SHOWN_CHARACTERS, format_value
from robotcore.errors import BackendMissingError, DescriptionError, Mistake, UnknownNameError
from robotcore.hal.kind import load_kind
from robotcore.hardware.driver import Connection, DeviceBinding, DeviceDriver
from robotcore.plugins import DEVICES, device_driver_names, load_registered
from robotcore.text import suggestion


def bind_devices(
    robot: RobotDescription,
    section: str,
    names: Iterable[str] | None = None,
    place: Callable[[Connection], Iterable[Connection]] = lambda _wire: (),
    missing_connectors: Collection[str] = (),
) -> tuple[DeviceBinding, ...]:
    """Return devices of a robot with their drivers and settings.

    A device of an optional kind, such as a display, is left out without a table in the section. All tables of the
    section are checked.

    section: the name of the backend's section in the robot's file.
    names: the names of the devices to return. None returns all.
    place: a function that returns the further pins that a connection occupies, such as the two pins of a serial port.
        It raises ValueError if the board has no such pin. The text of the error is the problem, a semicolon and a
        remedy.
    missing_connectors: the connectors that the backend lacks. Errors do not suggest the drivers that need one.

    Raises DescriptionError with all mistakes in the section.

    >>> from robotcore.description import load_robot
    >>> [binding.label for binding in bind_devices(load_robot("rover"), "raspberrypi", ["left_motor", "nose"])]
    ['motor, h-bridge', 'range sensor, hc-sr04']
    """
    chosen = {device.name for device in robot.devices} if names is None else set(names)
    wired = [
        description.name
        for description in robot.devices
        if description.name in chosen and not load_kind(description.kind).is_optional
    ]
    if section not in robot.backends and wired:
        others = " or ".join(f"--backend {name}" for name in sorted(robot.backends))
        remedy = f"Add a table for each device, such as [{section}.{wired[0]}]" + f", or name {others}" * bool(others)
        raise DescriptionError(robot.source, section, "is missing", remedy, kind="no-section")
    read, explain = partial(_bind, missing_connectors), partial(_missing_hint, missing_connectors)
    bindings, mistakes = read_each(robot, section, wired, read, explain)
    mistakes += [*_contradictions(section, bindings, robot), *_pin_mistakes(section, bindings, place)]
    if mistakes:
        raise DescriptionError.of_all(robot.source, mistakes)
    return tuple(binding for binding in bindings if binding.name in chosen)


def _bind(lacks: Collection[str], description: DeviceDescription, table: Any) -> DeviceBinding:
    kind = _driver(lacks, description, table)
    settings = {name: value for name, value in table.items() if name != "driver"}
    return DeviceBinding(description, validate_table(kind, settings))


def _driver(lacks: Collection[str], description: DeviceDescription, table: Any) -> type[DeviceDriver]:
    if not isinstance(table, Mapping):
        raise Mistake(
            f"should be a table, got {format_value(table)}", f"Name its driver: {_list_drivers(lacks, description)}"
        )
    if "driver" not in table:
        raise Mistake("is missing", f"Add it: {_list_drivers(lacks, description)}", key="driver")
    if not isinstance(name := table["driver"], str):
        problem = f"should be a name in quotes, got {format_value(name)}"
        raise Mistake(problem, f"Name one: {_list_drivers(lacks, description)}", key="driver")
    try:
        driver: type[DeviceDriver] = load_registered("device driver", DEVICES, name)
    except UnknownNameError as unknown:
        problem = f"unknown device driver {name[:MAX_SHOWN_CHARACTERS]!r}"
        raise Mistake(problem, _suggest_driver(name, lacks, description), key="driver") from unknown
    if not isinstance(description, driver.described):
        problem = f"{name!r} is not a driver for a {description.kind.replace('_', ' ')}"
        raise Mistake(problem, f"Name one: {_list_drivers(lacks, description)}", key="driver")
    return driver


def _missing_hint(lacks: Collection[str], description: DeviceDescription) -> str:
    removal = f"remove {description.name!r} from [[devices]]"
    if not (drivers := _find_drivers(type(description), lacks)):
        kind = description.kind.replace("_", " ")
        return f"No installed driver of this backend opens a {kind}. Install a package with one, or {removal}"
    return f"Add a table with one of these drivers: {', '.join(drivers)}. If the robot has no such device, {removal}"


def list_drivers(description: type[DeviceDescription]) -> list[str]:
    """Return the names of the drivers that open devices with a class of descriptions.

    description: the class of the descriptions, such as ServoDescription.

    >>> from robotcore.kinds.servo import ServoDescription
    >>> "servo" in list_drivers(ServoDescription)
    True
    """
    return list(_find_drivers(description))


def _list_drivers(lacks: Collection[str], description: DeviceDescription) -> str:
    return ", ".join(_find_drivers(type(description), lacks)) or "(none is installed)"


def _suggest_driver(name: str, lacks: Collection[str], description: DeviceDescription) -> str:
    drivers = _find_drivers(type(description), lacks)
    word = _normalise(name)
    same = [driver for driver in drivers if _normalise(driver) == word]
    alike = [
        driver
        for driver, kind in drivers.items()
        if any(part in word or (len(word) > 2 and word in part) for part in map(_normalise, kind.aliases))
    ]
    for driver in same + alike:
        return f"Did you mean {driver!r}?"
    again = "" if drivers else " If a package registers it, install the package again: pip install -e ."
    return suggestion(name, list(drivers)) + again


def _normalise(word: str) -> str:
    return "".join(letter for letter in word.lower() if letter.isalnum())


def _find_drivers(
    description: type[DeviceDescription], missing_connectors: Collection[str] = ()
) -> dict[str, type[DeviceDriver]]:
    # Drivers that cannot be imported are left out.
    found = {}
    for name in device_driver_names():
        with suppress(BackendMissingError):
            driver: type[DeviceDriver] = load_registered("device driver", DEVICES, name)
            if issubclass(description, driver.described) and driver.connector not in missing_connectors:
                found[name] = driver
    return found


def _contradictions(section: str, bindings: Sequence[DeviceBinding], robot: RobotDescription) -> Iterator[Mistake]:
    drivers = {binding.name: binding.driver for binding in bindings}
    for binding in bindings:
        try:
            binding.driver.check(binding.description, robot, drivers)
        except ValueError as error:  # noqa: PERF203  all mistakes are reported
            yield Mistake.from_error(error, f"{section}.{binding.name}", "setting-conflict")


def _pin_mistakes(
    section: str, bindings: Iterable[DeviceBinding], place: Callable[[Connection], Iterable[Connection]]
) -> Iterator[Mistake]:
    taken: dict[tuple[str, str], tuple[str, Connection]] = {}
    for name, connection in ((binding.name, wire) for binding in bindings for wire in binding.driver.connections()):
        pins: Iterable[Connection] = ()
        try:
            pins = place(connection)
        except ValueError as error:
            yield Mistake.from_error(error, f"{section}.{name}.{connection.signal}", "unknown-pin")
        for wire in (connection, *pins):
            key = f"{section}.{name}.{wire.signal}"
            first, before = taken.setdefault((wire.bus, wire.where), (key, wire))
            if before is not wire and not wire.can_share(before):
                protocol = f", which uses {before.protocol}" if before.protocol else ""
                remedy = f", or {wire.remedy}" if wire.remedy and wire.signal == before.signal else ""
                problem = f"{wire} is already {first}{protocol}"
                yield Mistake(problem, f"Connect one of them elsewhere{remedy}", kind="pin-conflict", key=key)

"""A robot's devices as its file says that they are connected: a driver and its settings for each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from pydantic import ValidationError

from robotcore.description import AnyDevice, Described, DisplayDescription, RobotDescription
from robotcore.description.faults import LONGEST, faults_of
from robotcore.devices import Device
from robotcore.errors import (
    BackendMissingError,
    DescriptionError,
    DeviceError,
    RobotcoreError,
    UnknownNameError,
    nearest,
    suggestion,
)
from robotcore.guardian import CutoffSpec
from robotcore.hardware.connections import Connection
from robotcore.hardware.driver import DeviceDriver, Host
from robotcore.registry import DEVICES, device_driver_names, load_registered

Fault = tuple[str, str, str]


@dataclass(frozen=True)
class Fitting:
    """One device: what it is, which driver opens it, and how it is connected."""

    told: AnyDevice
    driver: DeviceDriver[Any, Any]
    settings: Described

    @property
    def name(self) -> str:
        return self.told.name

    @property
    def connections(self) -> tuple[Connection, ...]:
        return tuple(self.driver.connections(self.settings))

    @property
    def warnings(self) -> tuple[str, ...]:
        return tuple(self.driver.warnings(self.settings))

    @property
    def notes(self) -> tuple[str, ...]:
        """What whoever connects it must know, at last what may do harm."""
        return (*self.driver.notes(self.settings), *self.warnings)

    def open(self, host: Host) -> Device:
        """Open the device; raises DeviceError, for what its driver has not translated too."""
        try:
            return self.driver.open(self.told, self.settings, host)
        except RobotcoreError:
            raise
        except ImportError as error:
            raise DeviceError(self.name, f"a library is not installed ({error}). {self.driver.remedy}") from error
        except Exception as error:
            raise DeviceError(self.name, f"{type(error).__name__}: {error}".removesuffix(": ")) from error

    def cutoffs(self, host: Host) -> tuple[CutoffSpec, ...]:
        return tuple(self.driver.cutoffs(self.told, self.settings, host))


def fit(
    robot: RobotDescription,
    section: str,
    names: Iterable[str] | None = None,
    place: Callable[[Connection], object] = str,
) -> tuple[Fitting, ...]:
    """Return how the devices of those names, by default all, are connected, by a backend's ``section`` of the file.

    A display that the section does not tell of is left out: it needs no wires. ``place`` raises ValueError, the fault,
    a semicolon and the remedy, for a wire that goes to no place of the board. Raises DescriptionError, with all that is
    wrong.
    """
    table = robot.backends.get(section, {})
    chosen = {device.name for device in robot.devices} if names is None else set(names)
    wired = [told.name for told in robot.devices if told.name in chosen and not isinstance(told, DisplayDescription)]
    if section not in robot.backends and wired:
        remedy = f"Say how each device is connected, from [{section}.{wired[0]}] on"
        raise DescriptionError(robot.source, section, "is missing", remedy)
    meant = _meant_by_strangers(robot, table)
    faults: list[Fault] = list(_strangers(section, meant))
    fittings = []
    for told in robot.devices:
        if told.name in table:
            try:
                fittings.append(_fitting(told, section, table[told.name], robot))
            except _UnfitError as unfit:
                faults += unfit.faults
        elif told.name in wired and told.name not in meant.values():
            faults.append(_untold(told, section))
    faults += [*_at_odds(section, fittings, robot), *_misplaced(section, fittings, place), *_clashes(section, fittings)]
    if faults:
        raise DescriptionError.of_all(robot.source, faults)
    return tuple(fitting for fitting in fittings if fitting.name in chosen)


class _UnfitError(Exception):
    def __init__(self, *faults: Fault) -> None:
        super().__init__(faults)
        self.faults = faults


def _fitting(told: AnyDevice, section: str, table: Any, robot: RobotDescription) -> Fitting:
    key = f"{section}.{told.name}"
    driver = _driver(told, key, table)
    settings = _settings(driver, key, {name: value for name, value in table.items() if name != "driver"})
    if refused := list(_refused(key, partial(driver.check, told, settings, robot))):
        raise _UnfitError(*refused)
    return Fitting(told, driver, settings)


def _driver(told: AnyDevice, key: str, table: Any) -> DeviceDriver[Any, Any]:
    if not isinstance(table, Mapping):
        raise _UnfitError((key, f"should be a table, got {table!r}", f"Name its driver: {_choice(told)}"))
    if "driver" not in table:
        raise _UnfitError((f"{key}.driver", "is missing", f"Add it: {_choice(told)}"))
    if not isinstance(name := table["driver"], str):
        raise _UnfitError((f"{key}.driver", f"should be a name in quotes, got {name!r}", f"Name one: {_choice(told)}"))
    try:
        driver: DeviceDriver[Any, Any] = load_registered("device driver", DEVICES, name)()
    except UnknownNameError as unknown:
        fault = f"unknown device driver {name[:LONGEST]!r}"
        raise _UnfitError((f"{key}.driver", fault, _meant(name, told))) from unknown
    if not isinstance(told, driver.described):
        fault = f"{name!r} opens no {told.kind.replace('_', ' ')}"
        raise _UnfitError((f"{key}.driver", fault, f"Name one: {_choice(told)}"))
    return driver


def _settings(driver: DeviceDriver[Any, Any], key: str, table: Mapping[str, Any]) -> Described:
    try:
        return driver.settings.model_validate(table, strict=True)
    except ValidationError as error:
        faults = faults_of(error, driver.settings, table)
        told = ((f"{key}.{fault.key}".rstrip("."), fault.fault, fault.remedy) for fault in faults)
        raise _UnfitError(*told) from error


def _choice(told: AnyDevice) -> str:
    """Return the names of the drivers that take such a device."""
    return ", ".join(_drivers_of(told)) or "there is none for it"


def _meant(name: str, told: AnyDevice) -> str:
    """Return which driver of such a device was probably meant, by its name or by what it drives; or name them all."""
    drivers = _drivers_of(told)
    word = _plain(name)
    for driver, kind in drivers.items():
        if any(part in word or (len(word) > 2 and word in part) for part in map(_plain, kind.parts)):
            return f"Did you mean {driver!r}?"
    return suggestion(name, list(drivers))


def _plain(word: str) -> str:
    """Return a word as it may be written: ``Pi Camera``, ``pi-camera`` and ``picamera`` are one."""
    return "".join(letter for letter in word.lower() if letter.isalnum())


def _drivers_of(told: AnyDevice) -> dict[str, type[DeviceDriver[Any, Any]]]:
    """Return the drivers that take such a device, by their names, of those that can be loaded."""
    found = {}
    for name in device_driver_names():
        with suppress(BackendMissingError):
            driver: type[DeviceDriver[Any, Any]] = load_registered("device driver", DEVICES, name)
            if isinstance(told, driver.described):
                found[name] = driver
    return found


def _meant_by_strangers(robot: RobotDescription, table: Mapping[str, Any]) -> dict[str, str | None]:
    """Return the names in a section that no device has, and which device without a section each probably means."""
    names = [device.name for device in robot.devices]
    untold = [name for name in names if name not in table]
    return {name: nearest(name, untold) for name in table if name not in names}


def _strangers(section: str, meant: Mapping[str, str | None]) -> Iterator[Fault]:
    for name, device in meant.items():
        remedy = f"Did you mean {device!r}?" if device else "Take the section out, or add [[devices]] of that name"
        yield f"{section}.{name}", "no device has this name", remedy


def _untold(told: AnyDevice, section: str) -> Fault:
    return f"{section}.{told.name}", "is missing", f"Say how it is connected, first of all its driver: {_choice(told)}"


def _at_odds(section: str, fittings: Sequence[Fitting], robot: RobotDescription) -> Iterator[Fault]:
    drivers = {fitting.name: fitting.driver for fitting in fittings}
    for fitting in fittings:
        check = partial(fitting.driver.check_beside, fitting.told, fitting.settings, robot, drivers)
        yield from _refused(f"{section}.{fitting.name}", check)


def _misplaced(section: str, fittings: Iterable[Fitting], place: Callable[[Connection], object]) -> Iterator[Fault]:
    for fitting in fittings:
        for wire in fitting.connections:
            yield from _refused(f"{section}.{fitting.name}.{wire.signal}", partial(place, wire))


def _clashes(section: str, fittings: Iterable[Fitting]) -> Iterator[Fault]:
    """Yield every place to which two wires go, of which one would have it alone."""
    taken: dict[tuple[str, str], tuple[str, Connection]] = {}
    for fitting in fittings:
        for wire in fitting.connections:
            key = f"{section}.{fitting.name}.{wire.signal}"
            first, before = taken.setdefault((wire.bus, wire.where), (key, wire))
            if before is not wire and not (wire.is_shared and before.is_shared and wire.signal == before.signal):
                instead = f", or {wire.instead}" if wire.instead and wire.signal == before.signal else ""
                yield key, f"{wire} is already {first}", f"Connect one of them elsewhere{instead}"


def _refused(key: str, check: Callable[[], object]) -> Iterator[Fault]:
    """Yield what a check raises: ValueError, the fault, a semicolon and the remedy."""
    try:
        check()
    except ValueError as error:
        fault, _, remedy = str(error).rpartition("; ")
        yield (key, fault, remedy[:1].upper() + remedy[1:]) if fault else (key, remedy, "Correct it")

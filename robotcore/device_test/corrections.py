"""The corrections of a robot's file that a test of its devices has found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robotcore.description import RobotDescription
from robotcore.hal.backend import Backend
from robotcore.hardware import DeviceDriver, HardwareBackend

MEASURED = ("model", "control", "trim")
"""The settings of a motor that were measured at its wheel. They stay there, while the settings of the wires move."""


class Corrections:
    """The corrected tables of devices in a backend's section, and the corrected values of their descriptions.

    A backend without drivers, such as a simulator, has no tables to correct.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.backend import load_backend
    >>> corrections = Corrections(load_robot("rover"), load_backend("virtualpi"))
    >>> corrections.swap({"left_encoder": "right_encoder", "right_encoder": "left_encoder"})
    True
    >>> corrections.correct("left_encoder", "reversed")
    {'a': 21, 'b': 20}
    >>> corrections.tables["left_encoder"]
    {'driver': 'quadrature', 'a': 21, 'b': 20}
    """

    def __init__(self, robot: RobotDescription, backend: Backend) -> None:
        self.section: str | None = None
        """The section of the file with the tables of the devices; None without drivers."""
        self._before: dict[str, dict[str, Any]] = {}
        self._after: dict[str, dict[str, Any]] = {}
        self._drivers: dict[str, DeviceDriver] = {}
        self.values: dict[str, dict[str, Any]] = {}
        """The corrected values of the descriptions, by the name of the device."""
        if isinstance(backend, HardwareBackend):
            self.section = backend.section
            tables = robot.backends.get(backend.section, {})
            self._before = {name: _thaw(table) for name, table in tables.items()}
            self._after = {name: dict(table) for name, table in self._before.items()}
            self._drivers = {binding.name: binding.driver for binding in backend.bind(robot)}

    @property
    def tables(self) -> dict[str, dict[str, Any]]:
        """The corrected tables, by the name of the device. Tables without a change are left out."""
        return {name: table for name, table in self._after.items() if table != self._before[name]}

    def get_driver(self, device: str) -> DeviceDriver | None:
        """Return the driver of a device; None without one."""
        return self._drivers.get(device)

    def swap(self, sources: Mapping[str, str]) -> bool:
        """Give each device the table of another one, apart from `MEASURED`. Return False if one of them has no table.

        sources: the name of the device whose table belongs to each device, by its name.
        """
        names = {*sources, *sources.values()}
        if not names <= self._drivers.keys():
            return False
        tables, drivers = dict(self._after), dict(self._drivers)
        for name, source in sources.items():
            wires = {key: value for key, value in tables[source].items() if key not in MEASURED}
            measured = {key: value for key, value in tables[name].items() if key in MEASURED}
            is_alike = type(drivers[name]) is type(drivers[source])
            self._set_table(name, wires | measured if is_alike else tables[source], type(drivers[source]))
        return True

    def correct(self, device: str, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        """Correct a mistake by settings of the device's driver. Return the settings; None if no setting corrects it."""
        driver = self._drivers.get(device)
        if driver is None or (settings := driver.correct(mistake, observed)) is None:
            return None
        self._set_table(device, {**self._after[device], **settings}, type(driver))
        return settings

    def _set_table(self, device: str, table: dict[str, Any], driver: type[DeviceDriver]) -> None:
        self._after[device] = table
        self._drivers[device] = driver.model_validate({key: each for key, each in table.items() if key != "driver"})

    def correct_description(self, device: str, values: Mapping[str, Any]) -> None:
        """Correct values of a device's description."""
        self.values.setdefault(device, {}).update(values)


def _thaw(value: Any) -> Any:
    """Return a value of a description with dicts and lists in place of its frozen mappings and tuples."""
    if isinstance(value, Mapping):
        return {key: _thaw(each) for key, each in value.items()}
    return [_thaw(each) for each in value] if isinstance(value, (tuple, list)) else value

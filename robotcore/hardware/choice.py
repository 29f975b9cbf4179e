"""Which drivers there are for a device, and which one a word means."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from robotcore.description import AnyDevice
from robotcore.errors import BackendMissingError, suggestion
from robotcore.hardware.driver import DeviceDriver
from robotcore.plugins import DEVICES, device_driver_names, load_registered


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

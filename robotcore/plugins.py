"""Names and where they lead, found by entry point: ours and everyone else's alike."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from robotcore.errors import BackendMissingError, UnknownNameError, UsageError

BACKENDS = "robotcore.backends"
APPS = "robotcore.apps"
FAULTS = "robotcore.faults"
DEVICES = "robotcore.devices"


def backend_names() -> list[str]:
    """Return the names of all backends, installed or not."""
    return sorted(_points(BACKENDS))


def app_names() -> list[str]:
    """Return the names of all apps."""
    return sorted(_points(APPS))


def fault_names() -> list[str]:
    """Return the names of all faults: an effect, and behind a dot what it is on where several have that effect."""
    return sorted(_points(FAULTS))


def device_driver_names() -> list[str]:
    """Return the names of all device drivers, whether or not their libraries are there."""
    return sorted(_points(DEVICES))


def load_registered(kind: str, group: str, name: str) -> Any:
    """Return what a name of a group leads to; ``kind`` is what messages call it.

    Raises UnknownNameError, with the nearest name, or BackendMissingError where it cannot be imported.
    """
    points = _points(group)
    if not points:
        raise UsageError(f"no {kind} is registered. Install the project first: pip install -e .")
    if name not in points:
        raise UnknownNameError(kind, name, list(points))
    try:
        return points[name].load()
    except Exception as error:
        raise BackendMissingError(
            f"the {kind} {name!r} ({points[name].value}) cannot be loaded: {error}. Reinstall the package it comes from"
        ) from error


@cache
def _points(group: str) -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=group)}

"""Lists and loads the backends, apps, faults, device kinds and drivers that packages register as entry points."""

from __future__ import annotations

from collections import defaultdict
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from robotcore.compatibility import PACKAGE, UPDATE, check_requirements
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError

__all__ = ["app_names", "backend_names", "device_driver_names", "fault_names", "kind_names"]

BACKENDS = "robotcore.backends"
APPS = "robotcore.apps"
FAULTS = "robotcore.faults"
DEVICES = "robotcore.devices"
KINDS = "robotcore.kinds"

_OWN_MODULES = (PACKAGE, "drivers", "apps")
"""The top-level modules of robotcore's own package."""


def backend_names() -> list[str]:
    """Return the names of all registered backends, even if their libraries are not installed.

    >>> "kinematic" in backend_names()
    True
    """
    return sorted(_points(BACKENDS))


def app_names() -> list[str]:
    """Return the names of all registered apps.

    >>> "green-search" in app_names()
    True
    """
    return sorted(_points(APPS))


def fault_names() -> list[str]:
    """Return the names of all registered faults, such as ``drop`` and ``noise.camera``.

    >>> "drop" in fault_names()
    True
    """
    return sorted(_points(FAULTS))


def device_driver_names() -> list[str]:
    """Return the names of all registered device drivers, even if their libraries are not installed.

    >>> "hc-sr04" in device_driver_names()
    True
    """
    return sorted(_points(DEVICES))


def kind_names() -> list[str]:
    """Return the names of all registered kinds of device, such as ``camera``.

    >>> "camera" in kind_names()
    True
    """
    return sorted(_points(KINDS))


def load_registered(kind: str, group: str, name: str) -> Any:
    """Import and return the object of an entry point.

    kind: the noun for the object in messages, such as ``backend``.
    group: the group of the entry point.
    name: the name of the entry point.

    Raises UsageError for an empty group and for a name that two packages register, UnknownNameError for an unknown
    name, and BackendMissingError for an object that cannot be imported or whose package needs another robotcore.
    """
    points = _points(group)
    if not points:
        text = f"no {kind} is registered. Install the project first: pip install -e ."
        raise UsageError(text, kind="nothing-registered", group=group)
    if name not in points:
        raise UnknownNameError(kind, name, list(points))
    if packages := _find_rivals(group).get(name):
        raise UsageError(
            f"the packages {' and '.join(packages)} both register the {kind} {name!r}. Uninstall one of them",
            kind="registered-twice",
            group=group,
            name=name,
        )
    _require_matching_package(kind, points[name])
    try:
        return points[name].load()
    except (Exception, SystemExit) as error:
        cause = f"its module exits with {error}" if isinstance(error, SystemExit) else error
        raise BackendMissingError(
            f"the {kind} {name!r} ({points[name].value}) cannot be loaded: {cause}. Reinstall its package",
            group=group,
            name=name,
        ) from error


def _require_matching_package(kind: str, point: EntryPoint) -> None:
    """Raise BackendMissingError if the package of an entry point needs another version of robotcore.

    pip refuses to install such a package. It can still be here, for example after an update of robotcore.
    """
    if point.dist is None or point.module.partition(".")[0] in _OWN_MODULES:
        return
    if unmet := check_requirements(point.dist.requires or ()):
        package = f"{point.dist.name} {point.dist.version}"
        is_old = unmet.remedy != UPDATE
        remedy = f"Install a version of {point.dist.name} for this robotcore" if is_old else unmet.remedy
        raise BackendMissingError(
            f"the {kind} {point.name!r} is in the package {package}, which needs robotcore {unmet.needed}, and this is "
            f"robotcore {unmet.installed}. {remedy}",
            kind="robotcore-version",
            package=point.dist.name,
            needed=unmet.needed,
            installed=unmet.installed,
        )


@cache
def _scan_packages() -> Any:
    # This reads the metadata of all installed packages, so it takes a while on a slow disk.
    return entry_points()


@cache
def _list_points(group: str) -> tuple[EntryPoint, ...]:
    return tuple(_scan_packages().select(group=group))


@cache
def _points(group: str) -> dict[str, EntryPoint]:
    return {point.name: point for point in _list_points(group)}


@cache
def _find_rivals(group: str) -> dict[str, list[str]]:
    """Return the packages that register a name with different objects, by the name."""
    found: dict[str, dict[str, EntryPoint]] = defaultdict(dict)
    for point in _list_points(group):
        found[point.name].setdefault(point.value, point)
    # Python reads and parses a file for the name of a package.
    return {
        name: sorted(point.dist.name if point.dist else point.value for point in points.values())
        for name, points in found.items()
        if len(points) > 1
    }

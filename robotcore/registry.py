"""Backends and apps by name, found by entry point: ours and everyone else's alike."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any

from robotcore.errors import BackendMissingError, UnknownNameError, UsageError

if TYPE_CHECKING:
    from robotcore.backend import Backend
    from robotcore.behaviour import Behaviour

BACKENDS = "robotcore.backends"
APPS = "robotcore.apps"


def backend_names() -> list[str]:
    """Return the names of all backends, installed or not."""
    return sorted(_points(BACKENDS))


def app_names() -> list[str]:
    """Return the names of all apps."""
    return sorted(_points(APPS))


def load_backend(name: str) -> Backend:
    """Return the backend of that name; its own library is not imported yet."""
    backend: Backend = _load("backend", BACKENDS, name)()
    return backend


def app_name(name: str) -> str:
    """Return what an app is called in results: a file's own name, or the registered one with hyphens."""
    from robotcore.appfile import is_app_file

    return name if is_app_file(name) else name.replace("_", "-")


def load_app(name: str) -> type[Behaviour]:
    """Return the app of that name, an underscore counting as a hyphen; or the one in that ``.py`` file."""
    from robotcore.appfile import is_app_file, load_app_file

    if is_app_file(name):
        return load_app_file(name)
    app: type[Behaviour] = _load("app", APPS, app_name(name))
    return app


@cache
def _points(group: str) -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=group)}


def _load(kind: str, group: str, name: str) -> Any:
    points = _points(group)
    if not points:
        raise UsageError(f"no {kind} is registered. Install the project first: pip install -e .")
    if name not in points:
        raise UnknownNameError(kind, name, list(points))
    try:
        return points[name].load()
    except (ImportError, AttributeError) as error:
        raise BackendMissingError(
            f"the {kind} {name!r} ({points[name].value}) cannot be loaded: {error}. Reinstall the package it comes from"
        ) from error

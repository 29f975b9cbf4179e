"""Backends and apps by name."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from robotcore.appfile import is_app_file, load_app_file, refuse_other_file
from robotcore.backend import Backend
from robotcore.behaviour import Behaviour
from robotcore.errors import BackendMissingError
from robotcore.registry import APPS, BACKENDS, app_names, backend_names, load_registered


def load_backend(name: str) -> Backend:
    """Return the backend of that name; its own library is not imported yet."""
    backend: Backend = load_registered("backend", BACKENDS, name)()
    return backend


def loadable_backends() -> Iterator[Backend]:
    """Yield every backend, by name, but those of somebody's package that is broken."""
    for name in backend_names():
        with suppress(BackendMissingError):
            yield load_backend(name)


def load_app(name: str) -> type[Behaviour]:
    """Return the app of that name, an underscore counting as a hyphen; or the one in that ``.py`` file."""
    if is_app_file(name):
        return load_app_file(name)
    if app_name(name) not in app_names():
        refuse_other_file(name)
    app: type[Behaviour] = load_registered("app", APPS, app_name(name))
    return app


def app_name(name: str) -> str:
    """Return what an app is called in results: a file's own name, or the registered one with hyphens."""
    return name if is_app_file(name) else name.replace("_", "-")

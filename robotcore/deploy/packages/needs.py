"""What a project needs of what is installed at the desk, by name: entry points and extras."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from robotcore.deploy.project import Project
from robotcore.errors import BackendMissingError
from robotcore.hal.backend import load_backend
from robotcore.plugins import APPS, BACKENDS, DEVICES, load_registered
from robotcore.runtime.apps import app_name, is_app_file

RECORD = "record"
"""The extra that recordings need."""

_EXTRAS = re.compile(r"robotcore\[([\w,-]+)\]")


def needed(project: Project) -> list[EntryPoint]:
    """Return the entry points of the backend, of the drivers of the robot's devices, and of an app that is a name."""
    wanted = [(BACKENDS, project.backend), *((DEVICES, name) for name in _drivers(project))]
    if not is_app_file(project.app):
        wanted.append((APPS, app_name(project.app)))
    return [point for group, name in wanted for point in entry_points(group=group, name=name)]


def extras(project: Project) -> set[str]:
    """Return the extras of robotcore that it runs with: a backend and a device driver name theirs in their remedy."""
    remedies = [load_backend(project.backend).remedy]
    for name in _drivers(project):
        with suppress(BackendMissingError):  # of a package that is broken; `robotcore check` tells it
            remedies.append(load_registered("device driver", DEVICES, name).remedy)
    named = {extra for remedy in remedies for found in _EXTRAS.findall(remedy) for extra in found.split(",")}
    return named | ({RECORD} if project.is_recorded else set())


def _drivers(project: Project) -> set[str]:
    """Return the drivers that the robot's file names, where the backend reads such a section; DescriptionError."""
    robot = project.described()
    if not load_backend(project.backend).check(robot):
        return set()
    return {point.name for point in entry_points(group=DEVICES)} & set(_named(robot.backends))


def _named(value: Any) -> Iterator[str]:
    """Yield each ``driver`` in tables within tables."""
    if not isinstance(value, dict):
        return
    for key, item in value.items():
        if key == "driver" and isinstance(item, str):
            yield item
        yield from _named(item)

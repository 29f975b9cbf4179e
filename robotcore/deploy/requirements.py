"""Collects the requirements that pip installs on the robot."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from importlib.metadata import Distribution, EntryPoint, distributions, entry_points
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from packaging.markers import Marker
from packaging.requirements import InvalidRequirement, Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import NormalizedName, canonicalize_name

from robotcore.deploy.project import FILE, Project
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.plugins import APPS, BACKENDS, DEVICES, load_registered
from robotcore.runtime.apps import app_name, is_app_file

__all__ = ["ROBOTCORE", "Requirement", "SpecifierSet", "canonicalize_name", "collect_requirements"]

ROBOTCORE = "robotcore"

_EXTRA = re.compile(r'(?:(?P<rest>.*) and )?extra == "(?P<extra>[^"]+)"', re.DOTALL)
"""The pattern of the marker of an extra's requirement. Build tools write the extra at the end of the marker."""

_SECRET = re.compile(":.*@", re.DOTALL)
"""The pattern of the part of an address that may have a password."""


def collect_requirements(project: Project, site: Path, pinned: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the requirements of the project and of the sent packages, sorted, in pip's format.

    Environment markers stay in the requirements, because pip evaluates them on the robot for the robot's Python.

    project: the project.
    site: the folder of the sent packages. pip does not install these on the robot.
    pinned: further requirements, such as ``name==version``.
    Raises UsageError for a requirement that the robot cannot install: a file of this machine, an address with a
    password, or another version of a sent package.
    """
    sent = {canonicalize_name(each.metadata["Name"]): each for each in distributions(path=[str(site)])}
    own = {*find_extras(project), *project.deploy.extras}
    collector = _RequirementCollector(sent)
    for name in sent:
        collector.add(Requirement(f"{name}[{','.join(sorted(own))}]"))
    for text in (*_list_project_requirements(project), *pinned):
        collector.add(_parse(text))
    return tuple(sorted(collector.found))


class _RequirementCollector:
    """Collects requirements. In place of a sent package, it collects the requirements of that package."""

    def __init__(self, sent: Mapping[NormalizedName, Distribution]) -> None:
        self._sent = sent
        self._seen: set[tuple[str, str]] = set()
        self.found: set[str] = set()

    def add(self, requirement: Requirement) -> None:
        name = canonicalize_name(requirement.name)
        if (dist := self._sent.get(name)) is None:
            _require_installable(requirement)
            self.found.add(str(requirement))
            return
        _require_version(requirement, dist)
        for extra in {"", *requirement.extras}:
            if (name, extra) not in self._seen:
                self._seen.add((name, extra))
                for each in _list_requirements(dist, extra):
                    self.add(each)


def _list_requirements(dist: Distribution, extra: str) -> Iterator[Requirement]:
    """Yield the requirements of a distribution for an extra, or those without an extra if ``extra`` is empty."""
    for requirement in map(_parse, dist.requires or ()):
        of_extra = _EXTRA.fullmatch(str(requirement.marker or ""))
        if (of_extra["extra"] if of_extra else "") == extra:
            if of_extra:
                requirement.marker = Marker(of_extra["rest"]) if of_extra["rest"] else None
            yield requirement


def _list_project_requirements(project: Project) -> Iterator[str]:
    if project.is_package:  # its built metadata has them, dynamic ones too
        return
    yield from project.metadata.dependencies
    for extra in project.deploy.extras:
        yield from project.metadata.optional.get(extra, ())


def _parse(text: str) -> Requirement:
    try:
        return Requirement(text)
    except InvalidRequirement as error:  # its text may have a password
        shown, why = (_SECRET.sub(":****@", each) for each in (repr(text), str(error).splitlines()[0]))
        raise UsageError(
            f'{FILE}: {shown} is not a requirement: {why}. Write it in the format of pip: "numpy>=1.24"',
            kind="invalid-requirement",
        ) from None


def _require_version(requirement: Requirement, dist: Distribution) -> None:
    if not requirement.specifier.contains(dist.version, prereleases=True):
        raise UsageError(
            f"{requirement} is required, but version {dist.version} is installed here and would be sent. Install the "
            "required version, or change the requirement",
            kind="requirement-version",
            requirement=str(requirement),
            installed=dist.version,
        )


def _require_installable(requirement: Requirement) -> None:
    address = urlsplit(requirement.url or "")
    if address.scheme == "file":
        raise UsageError(
            f"{requirement.name} is required from a file of this machine, which the robot does not have. Put its code "
            "into the project, or require it by name and version",
            kind="requirement-from-file",
            requirement=requirement.name,
        )
    if address.password or (address.username and "ssh" not in address.scheme):  # git@ is no secret
        raise UsageError(
            f"{requirement.name} is required from an address with a user name or a password, which would be stored on "
            "the robot. Remove it from the address, and put it into ~/.netrc on the robot",
            kind="requirement-with-secret",
            requirement=requirement.name,
        )


RECORD, VIEW = "record", "view"
"""The extras of robotcore that recordings and the live page need."""

_EXTRAS = re.compile(r"robotcore\[([\w,-]+)\]")


def find_entry_points(project: Project) -> list[EntryPoint]:
    """Return the entry points of the project's backend and device drivers, and of its app if the app is installed."""
    keys = [(BACKENDS, project.deploy.backend), *((DEVICES, name) for name in _find_driver_names(project))]
    if not is_app_file(project.app):
        keys.append((APPS, app_name(project.app)))
    return [point for group, name in keys for point in entry_points(group=group, name=name)]


def find_extras(project: Project) -> set[str]:
    """Return the extras of robotcore that the project needs."""
    # backends and device drivers name their extras in the remedy for a missing package
    remedies = [load_backend(project.deploy.backend).remedy]
    for name in _find_driver_names(project):
        with suppress(BackendMissingError):  # a broken package, which `robotcore check` reports
            remedies.append(load_registered("device driver", DEVICES, name).remedy)
    named = {extra for remedy in remedies for found in _EXTRAS.findall(remedy) for extra in found.split(",")}
    needed = {RECORD: project.deploy.record, VIEW: project.deploy.view is not None}
    return named | {extra for extra, is_needed in needed.items() if is_needed}


def _find_driver_names(project: Project) -> set[str]:
    """Return the installed device drivers that the robot's file names. Without device drivers, return an empty set."""
    robot = project.load_description()
    if not load_backend(project.deploy.backend).check(robot):
        return set()
    return {point.name for point in entry_points(group=DEVICES)} & set(_walk_drivers(robot.backends))


def _walk_drivers(value: Any) -> Iterator[str]:
    if not isinstance(value, dict):
        return
    for key, item in value.items():
        if key == "driver" and isinstance(item, str):
            yield item
        yield from _walk_drivers(item)

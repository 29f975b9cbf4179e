"""The requirements that pip installs on the robot."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from importlib.metadata import Distribution, EntryPoint, distributions, entry_points
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from robotcore.deploy.project import FILE, Project
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.plugins import APPS, BACKENDS, DEVICES, load_registered
from robotcore.runtime.apps import app_name, is_app_file

try:
    from packaging.markers import Marker
    from packaging.requirements import InvalidRequirement, Requirement
    from packaging.specifiers import SpecifierSet
    from packaging.utils import NormalizedName, canonicalize_name
except ImportError as error:
    raise BackendMissingError(
        "robotcore deploy needs packaging, which is not installed. pip install packaging"
    ) from error

__all__ = ["ROBOTCORE", "Requirement", "SpecifierSet", "canonicalize_name", "collect_requirements"]

ROBOTCORE = "robotcore"

_EXTRA = re.compile(r'(?:(?P<rest>.*) and )?extra == "(?P<extra>[^"]+)"', re.DOTALL)
"""How builders write that something is for an extra only: at the end."""

_SECRET = re.compile(":.*@", re.DOTALL)
"""Where a password is in an address, however that is written."""


def collect_requirements(project: Project, site: Path, pinned: Iterable[str] = ()) -> tuple[str, ...]:
    """Return what pip is to install, sorted: of robotcore in ``site``, of the packages beside it, of the project.

    Markers stay as they are: the robot's pip decides by its own Python and machine. Raises UsageError for what a robot
    cannot install: a file of this machine's, an address with a password in it, another robotcore than this one.
    """
    brought = {canonicalize_name(each.metadata["Name"]): each for each in distributions(path=[str(site)])}
    own = _require_extras(project, brought[canonicalize_name(ROBOTCORE)])
    walk = _RequirementWalk(brought)
    for name in brought:
        walk.visit(Requirement(f"{name}[{','.join(sorted(own))}]"))
    for text in (*_project_requirements(project), *pinned):
        walk.visit(_parse(text))
    return tuple(sorted(walk.found))


class _RequirementWalk:
    """Goes from requirement to requirement: through what is brought to what is not."""

    def __init__(self, brought: Mapping[NormalizedName, Distribution]) -> None:
        self._brought = brought
        self._seen: set[tuple[str, str]] = set()
        self.found: set[str] = set()

    def visit(self, requirement: Requirement) -> None:
        name = canonicalize_name(requirement.name)
        if (dist := self._brought.get(name)) is None:
            _require_installable(requirement)
            self.found.add(str(requirement))
            return
        _require_version(requirement, dist)
        for extra in {"", *requirement.extras}:
            if (name, extra) not in self._seen:
                self._seen.add((name, extra))
                for each in _requires(dist, extra):
                    self.visit(each)


def _requires(dist: Distribution, extra: str) -> Iterator[Requirement]:
    """Yield what a distribution requires for an extra alone or, where that is empty, always."""
    for requirement in map(_parse, dist.requires or ()):
        of_extra = _EXTRA.fullmatch(str(requirement.marker or ""))
        if (of_extra["extra"] if of_extra else "") == extra:
            if of_extra:
                requirement.marker = Marker(of_extra["rest"]) if of_extra["rest"] else None
            yield requirement


def _project_requirements(project: Project) -> Iterator[str]:
    """Yield what ``[project]`` depends on; where it is a package, its own metadata tells that, and what is dynamic."""
    if project.is_package:
        return
    yield from project.metadata.dependencies
    for extra in project.extras:
        yield from project.metadata.optional.get(extra, ())


def _require_extras(project: Project, robotcore: Distribution) -> set[str]:
    """Return the extras to install, of robotcore and of the project; raises UnknownNameError."""
    known = {*robotcore.metadata.get_all("Provides-Extra", ()), *project.metadata.optional}
    for extra in project.extras:
        if extra not in known:
            raise UnknownNameError("extra", extra, sorted(known))
    return {*find_extras(project), *project.extras}


def _parse(text: str) -> Requirement:
    try:
        return Requirement(text)
    except InvalidRequirement as error:  # it quotes what may hold a password
        shown, why = (_SECRET.sub(":****@", each) for each in (repr(text), str(error).splitlines()[0]))
        raise UsageError(
            f"{FILE}: {shown} is no requirement: {why}. Write it as pip takes it", kind="invalid-requirement"
        ) from None


def _require_version(requirement: Requirement, dist: Distribution) -> None:
    if not requirement.specifier.contains(dist.version, prereleases=True):
        raise UsageError(
            f"{requirement} is required, and {dist.version} is installed here, which would be sent. Install the one "
            "that is required, or change what requires it",
            kind="requirement-version",
            requirement=str(requirement),
        )


def _require_installable(requirement: Requirement) -> None:
    address = urlsplit(requirement.url or "")
    if address.scheme == "file":
        raise UsageError(
            f"{requirement.name} is required from a file of this machine, which the robot does not have. Put its code "
            "into the project, or require it from where the robot finds it too",
            kind="requirement-from-file",
            requirement=requirement.name,
        )
    if address.password or (address.username and "ssh" not in address.scheme):  # git@ is nobody's secret
        raise UsageError(
            f"{requirement.name} is required from an address with a name or a password in it, which would be kept on "
            "the robot. Take it out, and put it into ~/.netrc there",
            kind="requirement-with-secret",
            requirement=requirement.name,
        )


RECORD = "record"
"""The extra that recordings need."""

_EXTRAS = re.compile(r"robotcore\[([\w,-]+)\]")


def find_entry_points(project: Project) -> list[EntryPoint]:
    """Return the entry points of the backend, of the drivers of the robot's devices, and of an app that is a name."""
    wanted = [(BACKENDS, project.backend), *((DEVICES, name) for name in _driver_names(project))]
    if not is_app_file(project.app):
        wanted.append((APPS, app_name(project.app)))
    return [point for group, name in wanted for point in entry_points(group=group, name=name)]


def find_extras(project: Project) -> set[str]:
    """Return the extras of robotcore that it runs with: a backend and a device driver name theirs in their remedy."""
    remedies = [load_backend(project.backend).remedy]
    for name in _driver_names(project):
        with suppress(BackendMissingError):  # of a package that is broken; `robotcore check` tells it
            remedies.append(load_registered("device driver", DEVICES, name).remedy)
    named = {extra for remedy in remedies for found in _EXTRAS.findall(remedy) for extra in found.split(",")}
    return named | ({RECORD} if project.is_recorded else set())


def _driver_names(project: Project) -> set[str]:
    """Return the drivers that the robot's file names, where the backend reads such a section; DescriptionError."""
    robot = project.load_description()
    if not load_backend(project.backend).check(robot):
        return set()
    return {point.name for point in entry_points(group=DEVICES)} & set(_find_drivers(robot.backends))


def _find_drivers(value: Any) -> Iterator[str]:
    """Yield each ``driver`` in tables within tables."""
    if not isinstance(value, dict):
        return
    for key, item in value.items():
        if key == "driver" and isinstance(item, str):
            yield item
        yield from _find_drivers(item)

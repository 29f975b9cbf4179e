"""Builds the bundle: the folder that a push sends, with the project's files, robotcore, and the user's packages."""

from __future__ import annotations

import json
import os
import shlex
import shutil
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution, version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import unquote, urlsplit

import robotcore
from robotcore.deploy.agent.releases import PROJECT, SITE
from robotcore.deploy.project import FILE, Project
from robotcore.deploy.requirements import ROBOTCORE, Requirement, collect_requirements, find_entry_points
from robotcore.deploy.staging import Listing, copy_files
from robotcore.deploy.wheels import read_pip_error, run_pip
from robotcore.description import read_table
from robotcore.errors import DeployError, UsageError
from robotcore.text import escape, list_names

MAX_LISTED_SECRETS = 50
"""The greatest number of files that the warning about secrets names."""


@dataclass(frozen=True)
class Bundle:
    """The folder that a push sends to the robot for a project."""

    project: Project
    folder: Path
    """The folder. It has the folders ``project``, with the user's files, and ``site``, with the sent packages."""
    requirements: tuple[str, ...]
    """The requirements that pip installs on the robot."""
    warnings: tuple[str, ...] = ()
    """Warnings for the user, such as the files that are not sent."""


def build_bundle(project: Project, folder: Path) -> Bundle:
    """Copy everything that a push sends into an empty folder, and return it as a bundle.

    `Release.write` adds the manifest of the release later.

    project: the project.
    folder: the empty folder.
    Raises UsageError for a broken link, for compiled code, and if the project names a file that must not be sent.
    Raises DeployError if a package cannot be built.
    """
    listing = _copy_project(project, folder / PROJECT)
    pinned, secrets = _fill_site(project, folder / PROJECT, folder / SITE)
    secrets = (*listing.secrets, *secrets)
    warning = f"left out because they may hold a secret: {list_names(secrets, MAX_LISTED_SECRETS)}"
    requirements = collect_requirements(project, folder / SITE, pinned)
    return Bundle(project, folder, requirements, (warning,) if secrets else ())


def _copy_project(project: Project, target: Path) -> Listing:
    target.mkdir()
    if project.folder is None:
        return Listing(())
    listing = copy_files(project.folder, target)
    for name in map(os.path.normpath, project.files):
        if name not in listing.names:
            is_secret = name in listing.secrets
            why = "may hold a secret" if is_secret else "is ignored by git"
            remedy = "Rename it" if is_secret else "Take it out of .gitignore"
            raise UsageError(
                f"{escape(name)} {why}, so it is not sent. The project does not run without it. {remedy}",
                kind="file-not-sent",
                file=name,
            )
    return listing


METADATA = ("METADATA", "entry_points.txt", "top_level.txt")
"""The files of robotcore's metadata that are sent. Its other files contain paths of this machine."""

_NOT_COPIED = shutil.ignore_patterns("__pycache__", "*.py[co]", ".*")


def _fill_site(project: Project, source: Path, site: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Install robotcore, the project's package, and packages from folders of this machine into ``site``.

    source: the copy of the project in the bundle.
    Returns the requirements of packages from an index, and the names of files that may hold a secret.
    """
    site.mkdir()
    _copy_robotcore(site)
    if project.folder and project.is_package:
        build_package(source, site)
    pinned: list[str] = []
    secrets: list[str] = []
    found = {point.dist.name: point.dist for point in find_entry_points(project) if point.dist}
    for name in sorted(found.keys() - {ROBOTCORE}):
        place = _find_origin(found[name])
        if isinstance(place, str):
            pinned.append(place)
        elif place != project.folder:
            secrets += build_package(place, site)
    return tuple(pinned), tuple(secrets)


def _copy_robotcore(site: Path) -> None:
    """Copy robotcore, the packages of its entry points, and the metadata with these entry points.

    The source is the folder of the running robotcore, because the working folder may have packages of the same names.
    """
    packages = Path(robotcore.__file__).parents[1]
    dist = distribution(ROBOTCORE)
    for package in {ROBOTCORE, *(point.value.partition(".")[0] for point in dist.entry_points)}:
        shutil.copytree(packages / package, site / package, ignore=_NOT_COPIED)
    metadata = site / f"{ROBOTCORE}-{dist.version}.dist-info"
    metadata.mkdir()
    for name in METADATA:
        if text := dist.read_text(name):
            (metadata / name).write_text(text, encoding="utf-8")


def _find_origin(dist: Distribution) -> Path | str:
    """Return the folder or archive that a distribution was installed from. Without one, return its requirement.

    Source: ``direct_url.json``, PEP 610.
    """
    origin: dict[str, Any] = json.loads(dist.read_text("direct_url.json") or "{}")
    url = origin.get("url", "")
    if not url:
        return f"{dist.name}=={dist.version}"
    if url.startswith("file:"):
        place = Path(unquote(urlsplit(url).path), origin.get("subdirectory", ""))
        if place.exists():
            return place
        raise DeployError(
            f"{dist.name} was installed from {place}, which no longer exists. Install it again from its new place",
            kind="package-folder-missing",
            package=dist.name,
        )
    vcs = origin.get("vcs_info")
    return f"{dist.name} @ {vcs['vcs']}+{url}@{vcs['commit_id']}" if vcs else f"{dist.name} @ {url}"


COMPILED_SUFFIXES = (".so", ".pyd", ".dylib")
"""The suffixes of files with machine code."""

_LOCAL_METADATA = ("RECORD", "direct_url.json", "REQUESTED", "INSTALLER")
"""The files of a package's metadata that contain paths of this machine. They are not sent."""


def build_package(source: Path, site: Path) -> tuple[str, ...]:
    """Install a package into ``site`` without its dependencies. Return the names of files that may hold a secret.

    The function builds a copy of a folder, so that no secret gets into the package and no file into the original.

    source: the package's folder, or an archive. The returned names begin with the folder's name.
    Raises DeployError if the package cannot be built. Raises UsageError if it has compiled code, because the robot may
    have another processor.
    """
    with TemporaryDirectory(prefix="robotcore-") as scratch:
        tree, built = Path(scratch, "source"), Path(scratch, "built")
        secrets = copy_files(source, tree).secrets if source.is_dir() else ()
        process = run_pip(
            [
                *("install", "--quiet", "--no-deps", "--no-compile", "--target", str(built)),
                *(["--no-build-isolation"] if _has_build_requirements(tree) else []),
                str(tree if source.is_dir() else source),
            ]
        )
        if process.returncode:
            raise DeployError(
                f"{escape(str(source))} cannot be built: {read_pip_error(process)}. Repeat the build: "
                f"pip wheel --no-deps {shlex.quote(str(source))}",
                kind="package-not-built",
            )
        _require_pure(source, built)
        shutil.rmtree(built / "bin", ignore_errors=True)  # the command-line programs
        for file in [each for name in _LOCAL_METADATA for each in built.glob(f"*.dist-info/{name}")]:
            file.unlink()
        shutil.copytree(built, site, dirs_exist_ok=True)
    return tuple(f"{source.name}/{name}" for name in secrets)


def _has_build_requirements(tree: Path) -> bool:
    """Return whether all build requirements of a package are installed. pip then needs no package index to build it."""
    if not (tree / FILE).is_file():
        return False
    table = read_table(str(tree / FILE)).get("build-system", {})
    return "requires" in table and all(map(_is_installed, table["requires"]))


def _is_installed(text: str) -> bool:
    requirement = Requirement(text)
    if requirement.marker and not requirement.marker.evaluate():
        return True
    try:
        return requirement.specifier.contains(version(requirement.name), prereleases=True)
    except PackageNotFoundError:
        return False


def _require_pure(source: Path, built: Path) -> None:
    compiled = next((file for file in built.rglob("*") if file.suffix in COMPILED_SUFFIXES), None)
    if compiled:
        raise UsageError(
            f"{escape(str(source))} has code compiled for this machine ({escape(compiled.name)}). Publish wheels of it "
            "for the robot, and name it in the project's dependencies",
            kind="compiled-code",
            file=compiled.name,
        )

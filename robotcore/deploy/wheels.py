"""Download wheels for a robot that has no network, and cache them on this machine."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from email import message_from_string
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZipFile

from robotcore.deploy.answers import ProbeAnswer
from robotcore.deploy.progress import Say
from robotcore.deploy.project import FILE, Project
from robotcore.deploy.requirements import Requirement, SpecifierSet, canonicalize_name
from robotcore.errors import DeployError, DescriptionError

OLDEST_GLIBC = {"x86_64": 5, "aarch64": 17}
"""The minor version of glibc 2 that a processor's oldest wheels are built for. Source: PEP 600, PEP 599."""

LEGACY = {
    "x86_64": ("manylinux2014_x86_64", "manylinux2010_x86_64", "manylinux1_x86_64"),
    "aarch64": ("manylinux2014_aarch64",),
}


@dataclass(frozen=True)
class Target:
    """The robot as pip sees it; versions as the robot reports them: ``3.11.2``, ``2.36``."""

    python: str
    machine: str
    libc: str = "glibc"
    libc_version: str = "2.17"

    @classmethod
    def of(cls, facts: ProbeAnswer) -> Target:
        """Return the target of a robot's answer to ``probe``."""
        return cls(facts.python, facts.machine, facts.libc, facts.libc_version)

    def __str__(self) -> str:
        return f"Python {self.python_version} on {self.machine}"

    @property
    def python_version(self) -> str:
        """Major and minor."""
        return ".".join(self.python.split(".")[:2])

    @property
    def platforms(self) -> tuple[str, ...]:
        """The platform tags of wheels that run there, the newest first; none where its C library is not glibc 2."""
        major, _, minor = self.libc_version.partition(".")
        if self.libc != "glibc" or major != "2" or self.machine not in OLDEST_GLIBC:
            return (f"linux_{self.machine}",)
        oldest = OLDEST_GLIBC[self.machine]
        versions = range(int(minor.partition(".")[0]), oldest - 1, -1)
        newer = tuple(f"manylinux_2_{version}_{self.machine}" for version in versions)
        return (*newer, *LEGACY[self.machine], f"linux_{self.machine}")

    @property
    def markers(self) -> dict[str, str]:
        """The environment that requirements are asked in (PEP 508)."""
        return {
            "implementation_name": "cpython",
            "implementation_version": self.python,
            "os_name": "posix",
            "platform_machine": self.machine,
            "platform_python_implementation": "CPython",
            "platform_release": "",
            "platform_system": "Linux",
            "platform_version": "",
            "python_full_version": self.python,
            "python_version": self.python_version,
            "sys_platform": "linux",
        }

    def require_python(self, project: Project) -> None:
        """Raise DeployError where the project needs another Python than the robot has, DescriptionError for no such."""
        needed = project.metadata.requires_python
        try:
            is_met = SpecifierSet(needed).contains(self.python, prereleases=True)
        except ValueError as error:
            remedy = 'Write it as pip takes it: ">=3.10"'
            raise DescriptionError(FILE, "project.requires-python", f"{needed!r} names no versions", remedy) from error
        if not is_met:
            raise DeployError(
                f"the project needs Python {needed}, and the robot has {self.python}. Take a newer system there, or "
                "another requires-python in pyproject.toml where it works with that one too",
                kind="python-version",
                required=needed,
                found=self.python,
            )


_NOT_FOUND = re.compile(r"No matching distribution found for ([^\s(]+)")
_UNREACHABLE = re.compile(r"NewConnectionError|NameResolutionError|ConnectTimeoutError|Network is unreachable")


def fetch_wheels(requirements: Iterable[str], target: Target, say: Say, cache: Path | None = None) -> Path:
    """Return a folder with a wheel for each of the requirements, and for all that they need on that robot.

    They are fetched once, and kept at the desk; remove the folder to fetch newer ones. Raises DeployError where
    something has no wheel for the robot, or where no index can be reached.
    """
    wanted = sorted(requirements)
    key = json.dumps([wanted, target.python_version, target.platforms])
    folder = (cache or _cache_folder()) / hashlib.sha256(key.encode()).hexdigest()[:16]
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=folder.parent) as scratch:
            whole = Path(scratch, "wheels")
            whole.mkdir()
            _download_all([Requirement(each) for each in wanted], target, whole, say)
            _move_to_cache(whole, folder)
    return folder


def _move_to_cache(whole: Path, folder: Path) -> None:
    """Give gathered wheels their place at once; somebody who was faster has put the same there."""
    try:
        whole.rename(folder)
    except OSError:
        if not folder.is_dir():
            raise


def _cache_folder() -> Path:
    """Return where programs keep what can be made again (XDG base directory specification)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "robotcore", "wheels")


def _download_all(requirements: list[Requirement], target: Target, folder: Path, say: Say) -> None:
    """Fetch what is required until nothing is missing: pip asks markers of its own Python, not of the robot's."""
    asked: list[Requirement] = []
    missing = list(_select_applicable(requirements, target, {""}))
    while missing:
        _require_names(missing)
        asked += missing
        say(f"fetching wheels for {target}")
        _download(asked, target, folder)
        missing = list(_find_missing(asked, target, folder))


def _require_names(requirements: Iterable[Requirement]) -> None:
    """Raise DeployError where something is to come from an address: pip there goes to it, whatever was brought."""
    for each in requirements:
        if each.url:
            raise DeployError(
                f"{each.name} is required from an address, where a robot without a network cannot get it. Require it "
                "by name and version, from an index; or put its code into the project; or connect the robot once, and "
                "push without --offline: what is installed there then is kept",
                kind="requirement-from-address",
                requirement=each.name,
            )


def _download(asked: Sequence[Requirement], target: Target, folder: Path) -> None:
    """Let pip fetch wheels for the robot; what has none is built here, where it is pure Python."""
    platforms = [word for platform in target.platforms for word in ("--platform", platform)]
    python = ("--implementation", "cp", "--python-version", target.python_version)
    where = ("--only-binary=:all:", "--dest", str(folder), "--find-links", str(folder), *python, *platforms)
    built: set[str] = set()
    while (answer := run_pip(["download", "--quiet", *where, "--", *map(str, asked)])).returncode:
        found = _NOT_FOUND.search(answer.stderr)
        if found is None:
            raise DeployError(
                f"the wheels for {target} cannot be fetched: {pip_error(answer)}", kind="wheels-not-fetched"
            )
        if _UNREACHABLE.search(answer.stderr):
            raise _unreachable(found[1], target)
        if found[1] in built or not _build_wheel(found[1], folder):
            raise _without_wheel(found[1], target)
        built.add(found[1])


def _build_wheel(requirement: str, folder: Path) -> bool:
    """Build a wheel from source into the folder; return whether there was one, and it is pure Python."""
    with TemporaryDirectory() as scratch:
        process = run_pip(["wheel", "--quiet", "--no-deps", "--wheel-dir", scratch, "--", requirement])
        pure = list(Path(scratch).glob("*-none-any.whl"))
        for wheel in pure:
            shutil.copy(wheel, folder)
        return process.returncode == 0 and bool(pure)


def _unreachable(requirement: str, target: Target) -> DeployError:
    return DeployError(
        f"no index of packages can be reached from here, and no wheel of {requirement} for {target} is kept. Connect "
        "this machine to the network once; from then on the wheels are kept",
        kind="index-unreachable",
        requirement=requirement,
    )


def _without_wheel(requirement: str, target: Target) -> DeployError:
    return DeployError(
        f"{requirement} has no wheel for {target}. Do without it or take a version that has one; or connect the robot "
        "once, and push without --offline: what is installed there then is kept",
        kind="no-wheel",
        requirement=requirement,
    )


def _find_missing(asked: Iterable[Requirement], target: Target, folder: Path) -> Iterator[Requirement]:
    """Yield what the wheels need on the robot, and no wheel is there for."""
    needs = {canonicalize_name(name): each for name, each in map(_read_metadata, folder.glob("*.whl"))}
    seen: set[str] = set()
    queue = list(asked)
    while queue:
        requirement = queue.pop()
        name = canonicalize_name(requirement.name)
        if name not in needs:
            yield requirement
        elif str(requirement) not in seen:
            seen.add(str(requirement))
            queue += _select_applicable(needs[name], target, {"", *requirement.extras})


def _select_applicable(
    requirements: Iterable[Requirement], target: Target, extras: Iterable[str]
) -> Iterator[Requirement]:
    """Yield the requirements that hold on the robot with one of those extras, without their markers."""
    environments = [{**target.markers, "extra": extra} for extra in extras]
    for each in requirements:
        if each.marker is None or any(map(each.marker.evaluate, environments)):
            held = Requirement(str(each))
            held.marker = None
            yield held


def _read_metadata(wheel: Path) -> tuple[str, list[Requirement]]:
    """Return the name of what is in a wheel, and what that requires."""
    with ZipFile(wheel) as opened:
        (file,) = (name for name in opened.namelist() if re.fullmatch(r"[^/]+\.dist-info/METADATA", name))
        metadata = message_from_string(opened.read(file).decode())
    return metadata["Name"], [Requirement(each) for each in metadata.get_all("Requires-Dist", ())]


def run_pip(words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run pip, quietly, and return what it said; the user's own configuration of it holds. Raises DeployError."""
    if find_spec("pip") is None:
        raise DeployError("pip is not installed here. Run python -m ensurepip", kind="no-pip")
    return subprocess.run(  # noqa: S603  words, and no shell to take them for anything else
        [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input", "--no-color", *words],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="backslashreplace",
        check=False,
    )


def pip_error(process: subprocess.CompletedProcess[str]) -> str:
    """Return what pip said went wrong: its last line that says error, or its last line."""
    lines = [line.strip() for line in process.stderr.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return (errors or lines or [f"exit status {process.returncode}"])[-1]

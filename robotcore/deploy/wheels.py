"""Downloads wheels for a robot without a network, and caches them on this machine."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.deploy.progress import OnText
from robotcore.deploy.project import FILE, Project
from robotcore.deploy.requirements import SpecifierSet
from robotcore.errors import DeployError, DescriptionError

MIN_GLIBC = {"x86_64": 5, "aarch64": 17}
"""The minor version of glibc 2 in the oldest manylinux tag of each processor. Source: PEP 600, PEP 599."""


@dataclass(frozen=True)
class Platform:
    """The Python, the processor and the C library of a robot, which determine the wheels that it can install.

    >>> target = Platform("3.11.2", "aarch64", libc_version="2.36")
    >>> print(target)
    Python 3.11 on aarch64
    >>> target.platforms[0], target.platforms[-1]
    ('manylinux_2_36_aarch64', 'linux_aarch64')
    """

    python: str
    """Python's version, such as ``3.11.2``."""
    machine: str
    """The processor, such as ``aarch64``."""
    libc: str = "glibc"
    """The C library."""
    libc_version: str = "2.17"
    """The version of the C library."""

    def __str__(self) -> str:
        return f"Python {self.python_version} on {self.machine}"

    @property
    def python_version(self) -> str:
        """Python's major and minor version, such as ``3.11``."""
        return ".".join(self.python.split(".")[:2])

    @property
    def platforms(self) -> tuple[str, ...]:
        """The platform tags of the wheels that the robot can install, the newest first.

        Without glibc 2, the only tag is ``linux_`` with the processor's name.
        """
        major, minor, *_ = (*self.libc_version.split("."), "0", "0")
        if self.libc != "glibc" or major != "2" or self.machine not in MIN_GLIBC:
            return (f"linux_{self.machine}",)
        versions = range(int(minor), MIN_GLIBC[self.machine] - 1, -1)
        newer = tuple(f"manylinux_2_{version}_{self.machine}" for version in versions)
        return (*newer, f"manylinux2014_{self.machine}", f"linux_{self.machine}")  # pip adds older names to the second

    @property
    def markers(self) -> dict[str, str]:
        """The robot's values of the variables in environment markers. Source: PEP 508."""
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
        """Raise DeployError if the project needs another version of Python.

        Raises DescriptionError if the project's ``requires-python`` is invalid.
        """
        needed = project.metadata.requires_python
        try:
            is_met = SpecifierSet(needed).contains(self.python, prereleases=True)
        except ValueError as error:
            remedy = 'Write it in the format of pip: ">=3.10"'
            raise DescriptionError(
                FILE, "project.requires-python", f"{needed!r} is not a range of versions", remedy
            ) from error
        if not is_met:
            raise DeployError(
                f"the project needs Python {needed}, and the robot has {self.python}. Install a newer system on the "
                "robot. Or change requires-python in pyproject.toml if the project works with that Python too",
                kind="python-version",
                required=needed,
                found=self.python,
            )


_ADDRESS = "0+from.an.address"
"""A version that no package has. It stands in place of the address of a requirement."""

_WANTS_ADDRESS = re.compile(rf"([\w.-]+)(?:\[[^]]*\])?==={re.escape(_ADDRESS)}")
_NOT_FOUND = re.compile(r"No matching distribution found for ([^\s(]+)")
_UNREACHABLE_INDEX = re.compile(r"NewConnectionError|NameResolutionError|ConnectTimeoutError|Network is unreachable")


def fetch_wheels(requirements: Iterable[str], target: Platform, report: OnText, cache: Path | None = None) -> Path:
    """Return a folder with the wheels of the requirements and of all their dependencies.

    The wheels are downloaded once, and then kept in the cache. To download newer ones, delete the folder.

    requirements: the requirements, in pip's format.
    target: the robot's platform.
    report: this function is called with the current activity in words.
    cache: the folder of the cache; by default ``~/.cache/robotcore/wheels``.
    Raises DeployError if a requirement has an address or no wheel for the robot, or if no package index can be reached.
    """
    texts = sorted(requirements)
    key = json.dumps([texts, target.python_version, target.platforms])
    parent = cache or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "robotcore", "wheels")
    folder = parent / hashlib.sha256(key.encode()).hexdigest()[:16]
    if not folder.is_dir():
        parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=parent) as scratch:
            whole = Path(scratch, "wheels")
            whole.mkdir()
            report(f"downloading wheels for {target}")
            _download(texts, target, whole)
            try:
                whole.rename(folder)
            except OSError:
                if not folder.is_dir():  # else another process has cached the same wheels
                    raise
    return folder


def _download(requirements: Sequence[str], target: Platform, folder: Path) -> None:
    """Download wheels for the robot. If a pure Python package has no wheel, build one."""
    platforms = [word for platform in target.platforms for word in ("--platform", platform)]
    python = ("--implementation", "cp", "--python-version", target.python_version)
    where = ("--only-binary=:all:", "--dest", str(folder), "--find-links", str(folder), *python, *platforms)
    command = ("download", "--quiet", *where, "--", *requirements)
    built: set[str] = set()
    while (answer := run_pip(command, target.markers)).returncode:
        if found := _WANTS_ADDRESS.search(answer.stderr):
            raise DeployError(
                f"{found[1]} is required from an address, which a robot without a network cannot reach. Require it by "
                "name and version, or put its code into the project. Or connect the robot once, and push without "
                "--offline: the robot keeps the installed package",
                kind="requirement-from-address",
                requirement=found[1],
            )
        if (found := _NOT_FOUND.search(answer.stderr)) is None:
            raise DeployError(
                f"the wheels for {target} cannot be downloaded: {read_pip_error(answer)}", kind="wheels-not-fetched"
            )
        if _UNREACHABLE_INDEX.search(answer.stderr):
            raise DeployError(
                f"no package index can be reached from this machine, and it has no wheel of {found[1]} for {target}. "
                "Connect this machine to the network once, and push again: it keeps the wheels",
                kind="index-unreachable",
                requirement=found[1],
            )
        if found[1] in built or not _build_pure_wheel(found[1], folder):
            raise DeployError(
                f"{found[1]} has no wheel for {target}. Use another version, or another package. Or connect the robot "
                "once, and push without --offline: the robot keeps the installed package",
                kind="no-wheel",
                requirement=found[1],
            )
        built.add(found[1])


def _build_pure_wheel(requirement: str, folder: Path) -> bool:
    with TemporaryDirectory() as scratch:
        process = run_pip(["wheel", "--quiet", "--no-deps", "--wheel-dir", scratch, "--", requirement])
        pure = list(Path(scratch).glob("*-none-any.whl"))
        for wheel in pure:
            shutil.copy(wheel, folder)
        return process.returncode == 0 and bool(pure)


_PIP_FOR_ROBOT = f"""
import json, runpy, sys
from pip._vendor.packaging import markers, requirements, specifiers

class Requirement(requirements.Requirement):
    def __init__(self, text):
        super().__init__(text)
        if self.url:
            self.url, self.specifier = None, specifiers.SpecifierSet("==={_ADDRESS}")

values = json.loads(sys.argv.pop(1))
markers.default_environment = lambda: dict(values)
requirements.Requirement = Requirement
runpy.run_module("pip", run_name="__main__", alter_sys=True)
"""
"""A Python program that runs pip for another machine without a network.

pip has options for the platform of the wheels, but it evaluates the markers of requirements for its own Python. It
would also connect to the addresses in requirements, which the robot cannot do later. So no version fits these.
"""


def run_pip(arguments: Sequence[str], markers: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run pip with the user's configuration, and return its output. Raises DeployError if pip is not installed.

    markers: the values of the robot's variables in environment markers; None to run pip for this machine.
    """
    if find_spec("pip") is None:
        raise DeployError("pip is not installed here. Run python -m ensurepip", kind="no-pip")
    program = ("-m", "pip") if markers is None else ("-c", _PIP_FOR_ROBOT, json.dumps(markers))
    return subprocess.run(  # noqa: S603  no shell
        [sys.executable, *program, "--disable-pip-version-check", "--no-input", "--no-color", *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="backslashreplace",
        check=False,
    )


def read_pip_error(process: subprocess.CompletedProcess[str]) -> str:
    """Return the last error message in pip's output, or else its last line or exit status."""
    lines = [line.strip() for line in process.stderr.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return (errors or lines or [f"exit status {process.returncode}"])[-1]

"""The robot as pip sees it: its Python, its processor, its C library."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore.deploy.connection.answers import ProbeAnswer
from robotcore.deploy.packages.requirements import SpecifierSet
from robotcore.deploy.project import Project
from robotcore.deploy.table import FILE
from robotcore.errors import DeployError, DescriptionError

OLDEST_GLIBC = {"x86_64": 5, "aarch64": 17}
"""The minor version of glibc 2 that a processor's oldest wheels are built for. Source: PEP 600, PEP 599."""

LEGACY = {
    "x86_64": ("manylinux2014_x86_64", "manylinux2010_x86_64", "manylinux1_x86_64"),
    "aarch64": ("manylinux2014_aarch64",),
}


@dataclass(frozen=True)
class Target:
    """What wheels have to fit; versions as the robot tells them: ``3.11.2``, ``2.36``."""

    python: str
    machine: str
    libc: str = "glibc"
    libc_version: str = "2.17"

    @classmethod
    def of(cls, facts: ProbeAnswer) -> Target:
        """Return the target that a robot's own facts tell of."""
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
        needed = project.told.requires_python
        try:
            is_met = SpecifierSet(needed).contains(self.python, prereleases=True)
        except ValueError as error:
            remedy = 'Write it as pip takes it: ">=3.10"'
            raise DescriptionError(FILE, "project.requires-python", f"{needed!r} names no versions", remedy) from error
        if not is_met:
            raise DeployError(
                f"the project needs Python {needed}, and the robot has {self.python}. Take a newer system there, or "
                "another requires-python in pyproject.toml where it works with that one too"
            )

"""The names of new projects: their spellings, their rules, and the names that systems and tools reserve."""

from __future__ import annotations

import re
from keyword import iskeyword

from robotcore.errors import UsageError

NAME = re.compile(r"[a-z][a-z0-9]*(?:[-_][a-z0-9]+)*")
"""Matches a name that is valid for a package, a module and a robot, if it has at most `MAX_NAME_LENGTH` characters."""

MAX_NAME_LENGTH = 64
"""The maximum number of characters of a robot's name. The new project's robot has the name of the project."""


WINDOWS_NAMES = frozenset(
    ["con", "prn", "aux", "nul", *(f"{port}{number}" for port in ("com", "lpt") for number in range(10))]
)
"""Names that no file on Windows can have. Source: Microsoft, "Naming Files, Paths, and Namespaces"."""

# fmt: off
CONFIGURATION_NAMES = frozenset([
    "conftest", "cz", "hatch", "lychee", "mise", "noxfile", "pdm", "pixi", "poetry", "pylintrc", "pylock", "pyrefly",
    "pytest", "ruff", "setup", "sitecustomize", "tach", "taplo", "towncrier", "tox", "ty", "typos", "usercustomize",
    "uv",
])
# fmt: on
"""Names of tools' own files. A tool reads such a ``.toml`` or ``.py`` in a project's root as its configuration."""


def spell_name(name: str) -> tuple[str, str, str]:
    """Return a project's name and the names of its module and its class."""
    return name, name.replace("-", "_"), "".join(part.capitalize() for part in re.split("[-_]", name))


def require_valid_name(name: str) -> None:
    """Raise UsageError if a name is not valid for a package, a module and a robot."""
    if _is_valid(name):
        return
    meant = _suggest_name(name)
    raise UsageError(
        f"{name!r} is not a valid name for a project. Use at most {MAX_NAME_LENGTH} characters: lower-case letters, "
        f"digits, and single - or _ between them. Begin with a letter{f'. Did you mean {meant!r}?' if meant else ''}",
        kind="invalid-project-name",
        name=name,
        meant=meant,
    )


def _is_valid(name: str) -> bool:
    return len(name) <= MAX_NAME_LENGTH and NAME.fullmatch(name) is not None


def _suggest_name(name: str) -> str:
    meant = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
    return meant if _is_valid(meant) else ""


def describe_reserved_use(module: str) -> str:
    """Return the use of a name that Python, Windows or a tool reserves; ``""`` if it is free.

    module: the name as that of a module, with ``_`` in place of ``-``.
    """
    if iskeyword(module):
        return "a keyword of Python"
    if module in WINDOWS_NAMES:
        return "a name that Windows reserves for a device"
    return "the name of a tool's configuration file" if module in CONFIGURATION_NAMES else ""

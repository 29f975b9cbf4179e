"""The version of this robotcore, and whether a file or a package that names a range of versions works with it."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, NamedTuple

from robotcore.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from packaging.specifiers import SpecifierSet

PACKAGE = "robotcore"

UPDATE = "Update robotcore"
"""The remedy for a file or a package of a newer robotcore."""


MAX_RANGE_LENGTH = 100
"""The maximum number of characters of a range. Python would refuse a number of thousands of digits."""


class UnmetRange(NamedTuple):
    """A range of versions that this robotcore is not in."""

    needed: str
    """The range, such as ``>=0.3``."""
    installed: str
    """The version of this robotcore."""
    remedy: str
    """An instruction for the user, as a sentence without its full stop."""


@cache
def read_version() -> str:
    """Return the version of this robotcore. Raises UsageError if robotcore is not installed.

    The version stands in ``pyproject.toml`` only. Installing robotcore copies it into the metadata that are read here.
    """
    try:
        return version(PACKAGE)
    except PackageNotFoundError:
        text = "robotcore is not installed in this environment, so its version is unknown. Install it: pip install -e ."
        raise UsageError(text, kind="nothing-registered") from None


def format_minimum() -> str:
    """Return the range from the first release of this minor version on, such as ``>=0.1``."""
    return f">={'.'.join(read_version().split('.')[:2])}"


def is_newer(other: str) -> bool:
    """Return whether a version is newer than this robotcore. A text that is no version is not newer.

    >>> is_newer("1000.0"), is_newer("0.0.1"), is_newer("unknown")
    (True, False, False)
    """
    from packaging.version import Version

    try:
        return Version(other) > Version(read_version())
    except ValueError:  # InvalidVersion is one, and so is that of a number with too many digits
        return False


def check_range(needed: str) -> UnmetRange | None:
    """Return the range if this robotcore is not in it, else None.

    needed: the range, such as ``>=0.2`` or ``>=0.2,<1``, in the syntax of pip.

    Raises ValueError for a text that is no range, or that is longer than `MAX_RANGE_LENGTH`.

    >>> check_range(">=0.0.1")
    >>> check_range(">=1000").remedy
    'Update robotcore'
    """
    from packaging.specifiers import SpecifierSet

    if len(needed) > MAX_RANGE_LENGTH:
        raise ValueError(
            f"a range of versions has at most {MAX_RANGE_LENGTH} characters, and this one has {len(needed)}"
        )
    return _compare(SpecifierSet(needed))


def check_requirements(requirements: Iterable[str]) -> UnmetRange | None:
    """Return the first range of robotcore that a package requires and this robotcore is not in, else None.

    requirements: the requirements of the package, such as ``robotcore[sim]>=0.2``. All of them must be met.
    """
    from packaging.markers import UndefinedComparison, UndefinedEnvironmentName
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    for text in requirements:
        try:
            requirement = Requirement(text)
            if canonicalize_name(requirement.name) != PACKAGE:
                continue
            is_active = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
            if is_active and (unmet := _compare(requirement.specifier)):
                return unmet
        except (ValueError, UndefinedComparison, UndefinedEnvironmentName):  # old tools installed such metadata
            continue
    return None


def _compare(needed: SpecifierSet) -> UnmetRange | None:
    from packaging.version import Version

    installed = read_version()
    # A version under development or a release candidate has what its release will have.
    if any(needed.contains(each, prereleases=True) for each in (installed, Version(installed).base_version)):
        return None
    is_old = any(
        each.operator in (">=", ">", "~=", "==") and Version(each.version.removesuffix(".*")) >= Version(installed)
        for each in needed
    )
    remedy = UPDATE if is_old else "Install a version of robotcore in this range"
    return UnmetRange(str(needed), installed, remedy)

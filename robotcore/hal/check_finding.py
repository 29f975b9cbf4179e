"""Findings of `robotcore check` and `robotcore doctor`, and the function that runs checks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum


class Level(str, Enum):
    """The level of a finding."""

    OK = "ok"
    """All is right."""

    WARNING = "warning"
    """A run may be worse than it could be."""

    ERROR = "error"
    """A run fails, or is unsafe."""


@dataclass(frozen=True)
class Finding:
    """A result of `check` or `doctor`.

    >>> finding = Finding.warning("disk", "0.4 GB are free", "Delete old recordings", kind="disk-nearly-full")
    >>> finding.level.value, finding.kind
    ('warning', 'disk-nearly-full')
    """

    level: Level
    """How bad it is."""

    what: str
    """The subject in a word or two."""

    said: str
    """The result in words."""

    remedy: str = ""
    """The remedy; empty if all is right."""

    kind: str = field(kw_only=True)
    """A stable identifier of the finding, in kebab-case."""

    @classmethod
    def ok(cls, what: str, said: str, *, kind: str) -> Finding:
        """Return the finding that all is right."""
        return cls(Level.OK, what, said, kind=kind)

    @classmethod
    def warning(cls, what: str, said: str, remedy: str, *, kind: str) -> Finding:
        """Return the finding of a possible harm."""
        return cls(Level.WARNING, what, said, remedy, kind=kind)

    @classmethod
    def error(cls, what: str, said: str, remedy: str, *, kind: str) -> Finding:
        """Return the finding of a fault with which a robot does not run, or does not run safely."""
        return cls(Level.ERROR, what, said, remedy, kind=kind)

    @classmethod
    def unchecked(cls, what: str, why: str, remedy: str = "", *, kind: str = "unchecked") -> Finding:
        """Return the finding that a check failed, which is a warning."""
        return cls(Level.WARNING, what, f"could not be checked: {why}", remedy, kind=kind)


Check = Callable[[], Iterable[Finding]]
"""Yields findings. Raises any exception if the check fails."""


def findings_of(checks: Iterable[tuple[str, Check]]) -> Iterator[Finding]:
    """Make the checks, and yield their findings as they come.

    checks: each check with its subject. A check that raises yields the finding `Finding.unchecked`.

    >>> def disk() -> list[Finding]:
    ...     raise OSError("the disk does not answer")
    >>> [finding.said for finding in findings_of([("disk", disk)])]
    ['could not be checked: the disk does not answer']
    """
    for what, check in checks:
        try:
            yield from check()
        except Exception as error:  # noqa: BLE001, PERF203  any exception becomes a finding
            yield Finding.unchecked(what, _in_a_line(error))


def _in_a_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    text = " ".join(str(error).split())
    return text if text and isinstance(error, OSError | ValueError | RuntimeError) else _named(error, text)


def _named(error: Exception, text: str) -> str:
    return f"{type(error).__name__}: {text}".removesuffix(": ")

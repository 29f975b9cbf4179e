"""Findings of `robotcore check` and `robotcore doctor`, and the function that runs checks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum


class Level(str, Enum):
    """The level of a finding.

    >>> from robotcore.hal.check_finding import Finding
    >>> Finding.error("disk", "it is full", "Delete old recordings", kind="disk-full").level is Level.ERROR
    True
    """

    OK = "ok"
    """The check has found no problem."""

    WARNING = "warning"
    """A run is possible, but has a risk or a disadvantage."""

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
    """The severity of the finding."""

    subject: str
    """What was checked, in one or two words, such as ``disk``."""

    message: str
    """The result of the check."""

    remedy: str = ""
    """What the user must do; empty if there is no problem."""

    kind: str = field(kw_only=True)
    """A stable identifier of the finding, in kebab-case."""

    @classmethod
    def ok(cls, subject: str, message: str, *, kind: str) -> Finding:
        """Return a finding of level ``ok``."""
        return cls(Level.OK, subject, message, kind=kind)

    @classmethod
    def warning(cls, subject: str, message: str, remedy: str, *, kind: str) -> Finding:
        """Return a finding of level ``warning``, for a problem that does not prevent a run."""
        return cls(Level.WARNING, subject, message, remedy, kind=kind)

    @classmethod
    def error(cls, subject: str, message: str, remedy: str, *, kind: str) -> Finding:
        """Return a finding of level ``error``, for a problem that prevents a run or makes it unsafe."""
        return cls(Level.ERROR, subject, message, remedy, kind=kind)

    @classmethod
    def unchecked(cls, subject: str, why: str, remedy: str = "", *, kind: str = "unchecked") -> Finding:
        """Return a warning that a check could not be made."""
        return cls(Level.WARNING, subject, f"could not be checked: {why}", remedy, kind=kind)


Check = Callable[[], Iterable[Finding]]
"""Yields findings. Raises any exception if the check fails."""


def findings_of(checks: Iterable[tuple[str, Check]]) -> Iterator[Finding]:
    """Run the checks one after the other, and yield their findings.

    checks: pairs of a subject and a check. If a check raises an exception, `Finding.unchecked` is yielded.

    >>> from robotcore.hal.check_finding import Finding
    >>> def disk() -> list[Finding]:
    ...     raise OSError("the disk does not answer")
    >>> [finding.message for finding in findings_of([("disk", disk)])]
    ['could not be checked: the disk does not answer']
    """
    for subject, check in checks:
        try:
            yield from check()
        except Exception as error:  # noqa: BLE001, PERF203  any exception becomes a finding
            yield Finding.unchecked(subject, _in_a_line(error))


def _in_a_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    text = " ".join(str(error).split())
    is_clear = text and isinstance(error, OSError | ValueError | RuntimeError)
    return text if is_clear else f"{type(error).__name__}: {text}".removesuffix(": ")

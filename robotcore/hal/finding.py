"""Findings of `check` and `doctor`: level, subject, text and remedy, and how checks are run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum


class Level(str, Enum):
    """How bad it is: with an error a run fails or is unsafe, with a warning it may be worse than it could be."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Finding:
    """A result of `check` or `doctor`: its subject in a word or two, what was found, and the remedy if it is not ok.

    kind: a stable identifier of the finding, in kebab-case.

    >>> Finding.warning("disk", "0.4 GB are free", "Delete old recordings").level.value
    'warning'
    """

    level: Level
    what: str
    said: str
    remedy: str = ""
    kind: str = ""

    @classmethod
    def ok(cls, what: str, said: str, *, kind: str = "") -> Finding:
        """Return that it is as it should be."""
        return cls(Level.OK, what, said, kind=kind)

    @classmethod
    def warning(cls, what: str, said: str, remedy: str, *, kind: str = "") -> Finding:
        """Return what may do harm."""
        return cls(Level.WARNING, what, said, remedy, kind)

    @classmethod
    def error(cls, what: str, said: str, remedy: str, *, kind: str = "") -> Finding:
        """Return what keeps a robot from running, or from running safely."""
        return cls(Level.ERROR, what, said, remedy, kind)

    @classmethod
    def unchecked(cls, what: str, why: str, remedy: str = "", *, kind: str = "unchecked") -> Finding:
        """Return that nobody knows: never taken for ok."""
        return cls(Level.WARNING, what, f"could not be checked: {why}", remedy, kind)


Check = Callable[[], Iterable[Finding]]
"""Yields what it finds; raises where it cannot tell."""


def findings_of(checks: Iterable[tuple[str, Check]]) -> Iterator[Finding]:
    """Yield what the checks find, each under the name of what it looks at, as it is found.

    >>> def disk() -> list[Finding]:
    ...     raise OSError("the disk does not answer")
    >>> [finding.said for finding in findings_of([("disk", disk)])]
    ['could not be checked: the disk does not answer']
    """
    for what, check in checks:
        try:
            yield from check()
        except Exception as error:  # noqa: BLE001, PERF203  whatever a check comes across is text, and the next one made
            yield Finding.unchecked(what, _in_a_line(error))


def _in_a_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    text = " ".join(str(error).split())
    return text if text and isinstance(error, OSError | ValueError | RuntimeError) else _named(error, text)


def _named(error: Exception, text: str) -> str:
    return f"{type(error).__name__}: {text}".removesuffix(": ")

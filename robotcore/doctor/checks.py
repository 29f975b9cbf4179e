"""Checks, made one after the other; one that fails tells so, and keeps none from being made."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from robotcore.doctor.finding import Finding

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
        except Exception as error:  # noqa: BLE001, PERF203  whatever a check comes across is told, and the next one made
            yield Finding.unchecked(what, _in_a_line(error))


def _in_a_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    told = " ".join(str(error).split())
    return told if told and isinstance(error, OSError | ValueError | RuntimeError) else _named(error, told)


def _named(error: Exception, told: str) -> str:
    return f"{type(error).__name__}: {told}".removesuffix(": ")

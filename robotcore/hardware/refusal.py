"""What a device driver refuses, as faults of a robot's file."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from robotcore.description.sections import Fault


def refused(key: str, check: Callable[[], object]) -> Iterator[Fault]:
    """Yield what a check raises: ValueError, the fault, a semicolon and the remedy."""
    try:
        check()
    except ValueError as error:
        fault, _, remedy = str(error).rpartition("; ")
        yield (key, fault, remedy[:1].upper() + remedy[1:]) if fault else (key, remedy, "Correct it")

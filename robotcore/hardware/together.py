"""What is wrong with devices together, though each alone is right."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial

from robotcore.description import RobotDescription
from robotcore.description.sections import Fault
from robotcore.hardware.connections import Connection
from robotcore.hardware.fitting import Fitting
from robotcore.hardware.refusal import refused


def at_odds(section: str, fittings: Sequence[Fitting], robot: RobotDescription) -> Iterator[Fault]:
    """Yield what drivers refuse of what the robot's other devices have as drivers."""
    drivers = {fitting.name: fitting.driver for fitting in fittings}
    for fitting in fittings:
        check = partial(fitting.driver.check_beside, fitting.told, fitting.settings, robot, drivers)
        yield from refused(f"{section}.{fitting.name}", check)


def misplaced(section: str, fittings: Iterable[Fitting], place: Callable[[Connection], object]) -> Iterator[Fault]:
    """Yield what ``place`` refuses: a wire that goes to no place of the board."""
    for fitting in fittings:
        for wire in fitting.connections:
            yield from refused(f"{section}.{fitting.name}.{wire.signal}", partial(place, wire))


def clashes(
    section: str, fittings: Iterable[Fitting], place: Callable[[Connection], Iterable[Connection]]
) -> Iterator[Fault]:
    """Yield every place to which two wires go, of which one would have it alone; `fit` tells of ``place``."""
    taken: dict[tuple[str, str], tuple[str, Connection]] = {}
    for fitting in fittings:
        for wire in _wires(fitting, place):
            key = f"{section}.{fitting.name}.{wire.signal}"
            first, before = taken.setdefault((wire.bus, wire.where), (key, wire))
            if before is not wire and not wire.shares(before):
                yield (
                    key,
                    f"{wire} is already {first}{_spoken(before)}",
                    f"Connect one of them elsewhere{_or(wire, before)}",
                )


def _wires(fitting: Fitting, place: Callable[[Connection], Iterable[Connection]]) -> Iterator[Connection]:
    for wire in fitting.connections:
        yield wire
        with suppress(ValueError):  # what it refuses is told by `misplaced`
            yield from place(wire)


def _spoken(before: Connection) -> str:
    return f", where {before.spoken} is spoken" if before.spoken else ""


def _or(wire: Connection, before: Connection) -> str:
    return f", or {wire.instead}" if wire.instead and wire.signal == before.signal else ""

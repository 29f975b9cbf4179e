from __future__ import annotations

from itertools import pairwise

import pytest

from robotcore.geometry import Wheels
from robotcore.runtime.intervention_timer import InterventionTimer
from robotcore.runtime.trace import TickRecord
from robotcore.safety.velocity_limits import STOPPED, Intervention

FORWARD = Wheels(5.0, 5.0)


def changed(cause: str, time: float) -> Intervention:
    return Intervention(time, cause, FORWARD, STOPPED)


def guarded(time: float, *, asked: Wheels | None = FORWARD) -> TickRecord:
    return TickRecord(0, time, "drive", asked, STOPPED, (changed("range guard", time),))


def free(time: float, *interventions: Intervention) -> TickRecord:
    return TickRecord(0, time, "drive", FORWARD, FORWARD, interventions)


def silent(time: float, *interventions: Intervention, lost: str | None = None) -> TickRecord:
    """Return the record of a tick without a command."""
    return TickRecord(0, time, "wait", None, None, interventions, lost)


def measure(*records: TickRecord) -> dict[str, float]:
    timer = InterventionTimer()
    for record in records:
        timer.add(record)
    return timer.measure()


CASES = {
    "a changed command lasts until the next command": (
        [guarded(1.0), guarded(1.1), free(1.2), free(1.3)],
        {"range guard": 0.2},
    ),
    "a change of a command in force lasts until the next command": (
        [free(1.0), guarded(1.1, asked=None), silent(1.2), free(1.3)],
        {"range guard": 0.2},
    ),
    "a stop that a command ends lasts from its own time": (
        [free(1.0), free(3.0, changed("deadman", 1.25)), free(3.1)],
        {"deadman": 1.75},
    ),
    "a stop without a new command lasts until the next command": (
        [free(1.0), silent(1.3, changed("deadman", 1.25)), silent(2.0), free(2.25)],
        {"deadman": 1.0},
    ),
    "the loss of a device ends other causes": (
        [guarded(1.0), silent(1.1, lost="nose"), silent(2.0, lost="nose"), free(3.0, changed("lost device", 1.1))],
        {"range guard": 0.1, "lost device": 1.9},
    ),
    "two causes in one tick have the same duration": (
        [free(1.0, changed("range guard", 1.0), changed("acceleration limit", 1.0)), free(1.1)],
        {"range guard": 0.1, "acceleration limit": 0.1},
    ),
    "a stop after the last tick has no negative duration": ([silent(1.0, changed("deadman", 1.2))], {"deadman": 0.0}),
}


@pytest.mark.parametrize("records, durations", CASES.values(), ids=CASES)
def test_durations_of_causes(records: list[TickRecord], durations: dict[str, float]) -> None:
    assert measure(*records) == durations


def test_durations_are_rounded() -> None:
    times = [sum([0.05] * tick) for tick in range(11)]
    assert sum(later - time for time, later in pairwise(times)) != 0.5
    assert measure(*map(guarded, times)) == {"range guard": 0.5}

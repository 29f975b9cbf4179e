from __future__ import annotations

from itertools import pairwise

import pytest

from robotcore.geometry import Wheels
from robotcore.runtime.intervention_timer import InterventionTimer
from robotcore.runtime.trace import TickRecord
from robotcore.safety import STOPPED, Intervention

FORWARD = Wheels(5.0, 5.0)


def changed(cause: str, time: float) -> Intervention:
    return Intervention(time, cause, FORWARD, STOPPED)


def guarded(time: float, *, asked: Wheels | None = FORWARD) -> TickRecord:
    return TickRecord(0, time, "drive", asked, STOPPED, (changed("range guard", time),))


def free(time: float) -> TickRecord:
    return TickRecord(0, time, "drive", FORWARD, FORWARD, ())


def silent(time: float, *interventions: Intervention, lost: str | None = None) -> TickRecord:
    """Return the record of a tick without a command."""
    return TickRecord(0, time, "wait", None, None, interventions, lost)


@pytest.fixture
def timer() -> InterventionTimer:
    return InterventionTimer()


def measure(timer: InterventionTimer, *records: TickRecord) -> dict[str, float]:
    for record in records:
        timer.add(record)
    return timer.measure()


def test_changed_command_lasts_until_the_next_command(timer: InterventionTimer) -> None:
    assert measure(timer, guarded(1.0), guarded(1.1), free(1.2), free(1.3)) == {"range guard": 0.2}


def test_change_of_a_command_that_is_in_force_lasts_until_the_next_command(timer: InterventionTimer) -> None:
    assert measure(timer, free(1.0), guarded(1.1, asked=None), silent(1.2), free(1.3)) == {"range guard": 0.2}


def test_stop_that_a_command_ends_lasts_from_its_own_time(timer: InterventionTimer) -> None:
    late = free(3.0)._replace(interventions=(changed("deadman", 1.25),))
    assert measure(timer, free(1.0), late, free(3.1)) == {"deadman": 1.75}


def test_stop_without_a_new_command_lasts_until_the_next_command(timer: InterventionTimer) -> None:
    assert measure(timer, free(1.0), silent(1.3, changed("deadman", 1.25)), silent(2.0), free(2.25)) == {"deadman": 1.0}


def test_loss_of_a_device_ends_other_causes(timer: InterventionTimer) -> None:
    back = free(3.0)._replace(interventions=(changed("lost device", 1.1),))
    records = guarded(1.0), silent(1.1, lost="nose"), silent(2.0, lost="nose"), back
    assert measure(timer, *records) == {"range guard": 0.1, "lost device": 1.9}


def test_two_causes_in_one_tick_have_the_same_duration(timer: InterventionTimer) -> None:
    both = free(1.0)._replace(interventions=(changed("range guard", 1.0), changed("acceleration limit", 1.0)))
    assert measure(timer, both, free(1.1)) == {"range guard": 0.1, "acceleration limit": 0.1}


def test_time_of_a_stop_after_its_tick_does_not_make_the_duration_negative(timer: InterventionTimer) -> None:
    assert measure(timer, silent(1.0, changed("deadman", 1.2))) == {"deadman": 0.0}


def test_durations_are_rounded(timer: InterventionTimer) -> None:
    times = [sum([0.05] * tick) for tick in range(11)]
    assert sum(later - time for time, later in pairwise(times)) != 0.5
    assert measure(timer, *map(guarded, times)) == {"range guard": 0.5}

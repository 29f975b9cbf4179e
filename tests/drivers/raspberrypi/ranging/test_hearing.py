import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.raspberrypi.ranging.hearing import LONGEST_ECHO_S, SILENCE_S, STUCK_S, Acoustics, Hearing
from robotcore.devices import Range
from robotcore.errors import DeviceError

ACOUSTICS = Acoustics(speed=340.0, min_range=0.02, max_range=2.0, echo_free_cycles=3)
Kind = Literal["trigger", "wait", "rise", "fall"]
EDGES: list[Kind] = ["rise", "fall", "rise", "fall", "wait"]
LIMITS = [0.0, 1e-4, 0.005, LONGEST_ECHO_S, 0.0285, 0.031, 0.038, 0.038, 0.2, 0.4]
SECONDS = st.one_of(st.sampled_from(LIMITS), st.floats(0, 0.4))


@dataclass(frozen=True)
class Event:
    kind: Kind
    ticks: float


@st.composite
def events(draw: st.DrawFn) -> list[Event]:
    """Anything that pins and noise may do: edges missing, twice, late by a cycle or more, and in any order."""
    now, told = 1000.0, []
    pulse: list[Kind] = ["rise", "fall"]
    for edges in draw(st.lists(st.one_of(st.just(pulse), st.lists(st.sampled_from(EDGES), max_size=4)), max_size=12)):
        told.append(Event("trigger", now := now + 0.001))
        for kind in edges:
            now += draw(SECONDS)
            told.append(Event(kind, now - draw(st.sampled_from([0.0] * 8 + [0.05, 1.0]))))
    return told


def heard(told: list[Event]) -> Iterator[tuple[Range, int]]:
    """Yield every sample, and after how many events it came."""
    hearing = Hearing("nose", ACOUSTICS, 0.06, lambda later, earlier: later - earlier)
    last = None
    for count, event in enumerate(told, 1):
        match event.kind:
            case "trigger":
                hearing.begin(event.ticks, event.ticks)
            case "wait":
                hearing.wait()
            case _:
                hearing.edge(event.ticks, event.kind == "rise")
        try:
            sample = hearing.newest.get()
        except DeviceError:
            continue
        if sample is not last:
            last = sample
            yield sample, count


def pulses(told: list[Event]) -> list[float]:
    """Return the pulse of each trigger, in order; NaN where that was not one rise and then its fall.

    Edges from before their trigger are left out, and what comes after the pulse.
    """
    cycles: list[list[Event]] = []
    for event in told:
        if event.kind == "trigger":
            cycles.append([event])
        elif cycles and event.kind != "wait" and event.ticks >= cycles[-1][0].ticks:
            cycles[-1].append(event)
    edges = [cycle[1:3] for cycle in cycles]
    return [two[1].ticks - two[0].ticks if [e.kind for e in two] == ["rise", "fall"] else math.nan for two in edges]


@settings(max_examples=300)
@given(events())
def test_no_value_is_told_that_no_measured_pulse_supports(told: list[Event]) -> None:
    for sample, count in heard(told):
        *_, pulse = row = pulses(told[:count])
        if math.isfinite(sample.distance):
            assert sample.distance == pytest.approx(max(pulse * ACOUSTICS.speed / 2, ACOUSTICS.min_range))
            assert sample.distance <= ACOUSTICS.max_range
        elif not 2 * ACOUSTICS.max_range / ACOUSTICS.speed < pulse <= LONGEST_ECHO_S:
            assert len(row) >= 3
            assert all(SILENCE_S <= silent <= STUCK_S for silent in row[-3:])


@settings(max_examples=300)
@given(events())
def test_a_sample_is_of_the_newest_trigger_and_each_trigger_gives_one_at_most(told: list[Event]) -> None:
    samples = list(heard(told))
    for sample, count in samples:
        assert sample.time == max(event.ticks for event in told[:count] if event.kind == "trigger")
    assert all(before.time < after.time for (before, _), (after, _) in pairwise(samples))
    assert [sample.sequence for sample, _ in samples] == list(range(len(samples)))


def test_edges_before_the_first_trigger_say_nothing() -> None:
    hearing = Hearing("nose", ACOUSTICS, 0.06, lambda later, earlier: later - earlier)
    hearing.edge(1.0, is_high=True)
    hearing.edge(1.005, is_high=False)
    assert not hearing.has_told


def test_a_cycle_without_a_trigger_is_not_over_before_it_has_begun() -> None:
    hearing = Hearing("nose", ACOUSTICS, 0.06, lambda later, earlier: later - earlier)
    hearing.begin(0.0, 1.0)
    hearing.edge(1.001, is_high=False)
    assert hearing.ended.is_set()
    hearing.wait()
    assert not hearing.ended.is_set()


@pytest.mark.parametrize("pulse, is_vouched", [(0.0285, False), (0.031, True), (0.299, True), (0.301, False)])
def test_only_pulses_that_are_a_modules_time_out_make_a_cycle_echo_free(pulse: float, is_vouched: bool) -> None:
    hearing = Hearing("nose", ACOUSTICS, 0.06, lambda later, earlier: later - earlier)
    for cycle in range(ACOUSTICS.echo_free_cycles):
        hearing.begin(float(cycle), float(cycle))
        hearing.edge(cycle + 0.001, is_high=True)
        hearing.edge(cycle + 0.001 + pulse, is_high=False)
    assert hearing.has_told == is_vouched

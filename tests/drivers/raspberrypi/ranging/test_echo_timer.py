"""Echo pulses become samples: examples, and random sequences of edges."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.raspberrypi.ranging.echo_timer import LONGEST_ECHO_S, SILENCE_S, STUCK_S, EchoTimer
from robotcore.errors import DeviceError
from robotcore.hardware.polled_samples import RangeSampler
from robotcore.kinds.range_sensor import Range
from tests.drivers.raspberrypi.ranging.modules import NOSE

UNHURRIED = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
SPEED = 340.0
ECHO_FREE_CYCLES = 3
Kind = Literal["trigger", "wait", "rise", "fall"]
EDGES: list[Kind] = ["rise", "fall", "rise", "fall", "wait"]
LIMITS = [0.0, 1e-4, 0.005, LONGEST_ECHO_S, 0.0285, 0.031, 0.038, 0.038, 0.2, 0.4]
SECONDS = st.one_of(st.sampled_from(LIMITS), st.floats(0, 0.4))


@dataclass(frozen=True)
class Event:
    kind: Kind
    ticks: float


@st.composite
def event_rows(draw: st.DrawFn) -> list[Event]:
    """Return random sequences of edges: missing, double, late by a cycle or more, and in any order."""
    now, events = 1000.0, []
    pulse: list[Kind] = ["rise", "fall"]
    for edges in draw(st.lists(st.one_of(st.just(pulse), st.lists(st.sampled_from(EDGES), max_size=4)), max_size=12)):
        events.append(Event("trigger", now := now + 0.001))
        for kind in edges:
            now += draw(SECONDS)
            events.append(Event(kind, now - draw(st.sampled_from([0.0] * 8 + [0.05, 1.0]))))
    return events


def build_timer() -> tuple[RangeSampler, EchoTimer]:
    findings = RangeSampler(NOSE, ECHO_FREE_CYCLES)
    return findings, EchoTimer("nose", findings, SPEED, 0.06, lambda later, earlier: later - earlier)


def take_samples(events: list[Event]) -> Iterator[tuple[Range, int]]:
    """Yield each sample, and the number of events before it."""
    findings, timer = build_timer()
    last = None
    for count, event in enumerate(events, 1):
        match event.kind:
            case "trigger":
                timer.begin(event.ticks, event.ticks)
            case "wait":
                timer.skip_cycle()
            case _:
                timer.on_edge(event.ticks, event.kind == "rise")
        try:
            sample = findings.newest.get()
        except DeviceError:
            continue
        if sample is not last:
            last = sample
            yield sample, count


def pulses(events: list[Event]) -> list[float]:
    """Return the pulse of each trigger, in order; NaN if it is not one rise and its fall.

    Edges before the trigger and after the pulse are left out.
    """
    cycles: list[list[Event]] = []
    for event in events:
        if event.kind == "trigger":
            cycles.append([event])
        elif cycles and event.kind != "wait" and event.ticks >= cycles[-1][0].ticks:
            cycles[-1].append(event)
    edges = [cycle[1:3] for cycle in cycles]
    return [two[1].ticks - two[0].ticks if [e.kind for e in two] == ["rise", "fall"] else math.nan for two in edges]


@pytest.mark.slow
@UNHURRIED
@given(event_rows())
def test_every_sample_comes_from_a_measured_pulse_of_the_newest_trigger(events: list[Event]) -> None:
    samples = list(take_samples(events))
    for sample, count in samples:
        assert sample.time == max(event.ticks for event in events[:count] if event.kind == "trigger")
        *_, pulse = row = pulses(events[:count])
        if math.isfinite(sample.distance):
            assert sample.distance == pytest.approx(max(pulse * SPEED / 2, NOSE.min_range_m))
            assert sample.distance <= NOSE.max_range_m
        elif not 2 * NOSE.max_range_m / SPEED < pulse <= LONGEST_ECHO_S:
            assert len(row) >= ECHO_FREE_CYCLES
            assert all(SILENCE_S <= silent <= STUCK_S for silent in row[-ECHO_FREE_CYCLES:])
    assert all(before.time < after.time for (before, _), (after, _) in pairwise(samples))
    assert [sample.sequence for sample, _ in samples] == list(range(len(samples)))


def test_edges_before_the_first_trigger_are_ignored() -> None:
    findings, timer = build_timer()
    timer.on_edge(1.0, is_high=True)
    timer.on_edge(1.005, is_high=False)
    assert not findings.has_result


def test_a_cycle_without_a_trigger_does_not_end_at_once() -> None:
    _, timer = build_timer()
    timer.begin(0.0, 1.0)
    timer.on_edge(1.001, is_high=False)
    assert timer.ended.is_set()
    timer.skip_cycle()
    assert not timer.ended.is_set()


@pytest.mark.parametrize("pulse, is_vouched", [(0.0285, False), (0.031, True), (0.299, True), (0.301, False)])
def test_only_pulses_of_a_modules_time_out_make_a_cycle_echo_free(pulse: float, is_vouched: bool) -> None:
    findings, timer = build_timer()
    for cycle in range(ECHO_FREE_CYCLES):
        timer.begin(float(cycle), float(cycle))
        timer.on_edge(cycle + 0.001, is_high=True)
        timer.on_edge(cycle + 0.001 + pulse, is_high=False)
    assert findings.has_result == is_vouched

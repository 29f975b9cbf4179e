"""Simulated sensors take samples at their rate, and deliver them after their latency."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.hal.clock import SteppedClock
from robotcore.hal.sampling import DelayedSamples
from robotcore.kinds.encoder import Angle


class Probe:
    """A measurement that counts how often it was taken and how many samples were made of it."""

    def __init__(self) -> None:
        self.clock = SteppedClock(20, lambda steps: None)
        self.measured: list[float] = []
        self.made: list[float] = []

    def capture(self, time: float, sequence: int) -> Callable[[], Angle]:
        self.measured.append(time)

        def make() -> Angle:
            self.made.append(time)
            return Angle(0.0, time, sequence)

        return make

    def open(self, latency_s: float, rate_hz: float | None = None) -> DelayedSamples[Angle]:
        return DelayedSamples(self.clock, self.capture, latency_s, rate_hz)

    def step(self, ticks: int = 1) -> None:
        self.clock.sleep_until(self.clock.now() + ticks / 20)


@pytest.mark.parametrize("latency_s", [0.0125, 0.02, 0.05, 0.07, 0.1, 0.23])
def test_each_tick_has_a_new_sample_of_the_latency_without_a_rate(latency_s: float) -> None:
    probe = Probe()
    read = probe.open(latency_s)
    probe.step(8)
    ages, sequences = [], []
    for _ in range(5):
        probe.step()
        sample = read()
        ages.append(probe.clock.now() - sample.time)
        sequences.append(sample.sequence)
    assert ages == pytest.approx([latency_s] * 5, abs=probe.clock.step / 2 + 1e-9)
    assert sequences == list(range(sequences[0], sequences[0] + 5))


def test_a_sample_is_taken_at_its_exact_time_between_two_ticks() -> None:
    probe = Probe()
    read = probe.open(0.0, rate_hz=30)
    probe.step(4)
    assert probe.measured == pytest.approx([0.0, *(k / 30 for k in range(1, 7))])
    assert read().time == pytest.approx(0.2)


def test_a_slow_sensor_repeats_its_newest_sample() -> None:
    probe = Probe()
    read = probe.open(0.05, rate_hz=4)
    probe.step(6)
    assert read() == Angle(0.0, 0.25, 1)
    assert read() is read()
    probe.step(5)
    assert read() == Angle(0.0, 0.5, 2)


def test_the_first_sample_is_available_at_once() -> None:
    assert Probe().open(0.5)() == Angle(0.0, 0.0, 0)


def test_a_sample_that_nothing_reads_is_not_made() -> None:
    probe = Probe()
    read = probe.open(0.1)
    probe.step(100)
    assert len(probe.measured) > 90
    read()
    read()
    assert len(probe.made) == 1


def test_a_closed_sensor_measures_no_more() -> None:
    probe = Probe()
    for latency_s in (0.1, 0.02):
        samples = probe.open(latency_s)
        samples.close()
    measured = len(probe.measured)
    probe.step(10)
    assert len(probe.measured) == measured

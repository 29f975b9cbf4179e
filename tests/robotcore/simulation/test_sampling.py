"""test_sampling."""

from __future__ import annotations

from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Angle
from robotcore.simulation.sampling import OnceAnInstant


def test_a_sample_is_taken_when_it_is_read_and_once_an_instant() -> None:
    clock = SteppedClock(20.0, lambda steps: None)
    taken: list[Angle] = []

    def take(time: float, sequence: int) -> Angle:
        taken.append(Angle(0.0, time, sequence))
        return taken[-1]

    read = OnceAnInstant(clock, take)
    clock.sleep_until(1.0)
    assert not taken
    assert read() is read()
    clock.sleep_until(1.5)
    clock.sleep_until(2.0)
    assert read() is taken[1]
    assert [(sample.time, sample.sequence) for sample in taken] == [(1.0, 0), (2.0, 1)]

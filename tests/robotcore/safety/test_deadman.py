from __future__ import annotations

from threading import RLock

import pytest

from robotcore.hal.clock import SteppedClock
from robotcore.safety.deadman import Deadman
from robotcore.safety.thread_reserve import Reserve


class Bench:
    """A deadman with a lease of 0.125 s, and the times at which it stopped the motors."""

    def __init__(self, lease: float = 0.125) -> None:
        self.clock = SteppedClock(20, lambda _: None)
        self.cuts: list[tuple[float, float]] = []
        self.deadman = Deadman(self.clock, lease, self._cut, RLock(), Reserve(self.clock))

    def _cut(self, expiry: float) -> None:
        self.cuts.append((expiry, self.clock.now()))

    def renew(self) -> None:
        self.deadman.renew(self.clock.now())


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_stop_comes_exactly_at_expiry_during_a_longer_sleep(bench: Bench) -> None:
    bench.renew()
    bench.clock.sleep_until(1.0)
    assert bench.cuts == [(0.125, 0.125)]


def test_lease_counts_from_the_last_renewal(bench: Bench) -> None:
    for tick in range(1, 20):
        bench.renew()
        bench.clock.sleep_until(tick / 20)
    bench.clock.sleep_until(2.0)
    assert bench.cuts == [pytest.approx((1.025, 1.025))]


def test_renewal_at_the_last_moment_prevents_the_stop(bench: Bench) -> None:
    bench.renew()
    bench.clock.sleep_until(0.125 - 1 / 240)
    bench.renew()
    bench.clock.sleep_until(0.15)
    assert bench.cuts == []


def test_no_stop_comes_after_the_end_of_a_lease(bench: Bench) -> None:
    bench.renew()
    bench.deadman.end_lease()
    bench.clock.sleep_until(1.0)
    assert bench.cuts == []


def test_lease_can_be_renewed_after_a_stop(bench: Bench) -> None:
    bench.renew()
    bench.clock.sleep_until(0.5)
    bench.renew()
    bench.clock.sleep_until(1.0)
    assert [now for _, now in bench.cuts] == [0.125, 0.625]


def test_new_lease_is_not_ended_by_the_call_of_the_old_lease(bench: Bench) -> None:
    bench.renew()
    bench.deadman.end_lease()
    bench.clock.sleep_until(0.1)
    bench.renew()
    bench.clock.sleep_until(0.2)
    assert bench.cuts == []
    bench.clock.sleep_until(0.3)
    assert bench.cuts == [pytest.approx((0.225, 0.225))]


def test_lease_is_at_least_a_tenth_of_a_second() -> None:
    bench = Bench(lease=0.0025)
    assert bench.deadman.lease == 0.1
    bench.renew()
    bench.clock.sleep_until(0.095)
    assert bench.cuts == []


def test_clock_has_one_call_at_a_time(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []
    monkeypatch.setattr(bench.clock, "call_at", lambda deadline, _: asked.append(deadline))
    for _ in range(100):
        bench.renew()
    assert asked == [0.125]

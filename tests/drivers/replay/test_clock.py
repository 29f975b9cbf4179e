from __future__ import annotations

import pytest

from drivers.replay.clock import ReplayClock
from robotcore.errors import RecordingEndedError


def test_sleep_goes_to_the_next_tick_even_where_it_came_late() -> None:
    clock = ReplayClock([0.0, 0.31, 0.35])
    assert clock.sleep_until(0.05)
    assert clock.now() == 0.31


def test_deadline_that_is_a_sum_of_periods_skips_no_tick() -> None:
    times = [tick / 20 for tick in range(200)]
    clock, deadline = ReplayClock(times), 0.0
    for time in times[1:]:
        deadline += 0.05
        clock.sleep_until(deadline)
        assert clock.now() == time


def test_deadline_that_has_passed_is_told_and_still_goes_on() -> None:
    clock = ReplayClock([0.0, 0.4, 0.4])
    clock.sleep_until(0.05)
    assert not clock.sleep_until(0.1)
    assert (clock.now(), clock.tick) == (0.4, 2)


def test_sleep_goes_on_to_where_the_deadline_has_come() -> None:
    clock = ReplayClock([0.0, 0.05, 0.1, 0.15])
    clock.sleep_until(0.1)
    assert clock.tick == 2


def test_past_the_last_tick_the_recording_has_ended() -> None:
    clock = ReplayClock([0.0, 0.05])
    clock.sleep_until(0.05)
    with pytest.raises(RecordingEndedError, match=r"after 2 ticks, at 0\.05 s"):
        clock.sleep_until(0.1)


def test_calls_are_made_on_the_way_in_their_order_and_at_their_time() -> None:
    clock = ReplayClock([0.0, 0.1, 0.2])
    made: list[tuple[str, float]] = []
    clock.call_at(0.08, lambda: made.append(("second", clock.now())))
    clock.call_at(0.03, lambda: made.append(("first", clock.now())))
    clock.call_at(0.15, lambda: made.append(("third", clock.now())))
    clock.sleep_until(0.1)
    assert made == [("first", 0.03), ("second", 0.08)]
    assert clock.now() == 0.1


def test_closed_clock_has_forgotten_its_calls() -> None:
    clock = ReplayClock([0.0, 0.1])
    made: list[float] = []
    clock.call_at(0.05, lambda: made.append(clock.now()))
    clock.close()
    clock.sleep_until(0.1)
    assert not made


def test_time_that_is_a_little_past_the_deadline_is_the_deadline() -> None:
    clock = ReplayClock([0.0, 0.05, 0.1, 3 * 0.05])
    assert 3 * 0.05 > 0.15
    clock.sleep_until(0.15)
    assert clock.tick == 3

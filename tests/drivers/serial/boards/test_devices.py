from __future__ import annotations

from drivers.serial.boards.devices import CountAccumulator
from robotcore.hal.devices import Angle


def _add_counts(counter: CountAccumulator, *counts: float) -> float:
    for count in counts:
        counter.add(count, 0.0)
    angle = counter.angle(1.0)
    assert angle
    return angle.angle


def test_angles_begin_at_zero_for_any_first_count() -> None:
    assert _add_counts(CountAccumulator(), 700) == 0
    assert _add_counts(CountAccumulator(), 700, 690) == -10


def test_before_the_first_count_there_is_no_angle() -> None:
    assert CountAccumulator().angle(1.0) is None


def test_a_counter_wraps_in_both_directions() -> None:
    assert _add_counts(CountAccumulator(2**32), 2**31 - 5, -(2**31) + 5) == 10
    assert _add_counts(CountAccumulator(2**32), -(2**31) + 5, 2**31 - 5) == -10


def test_the_angle_continues_after_a_reset_of_the_board() -> None:
    counter = CountAccumulator()
    assert _add_counts(counter, 0, 100) == 100
    counter.restart()
    assert counter.angle(1.0) == Angle(100.0, 0.0, 1)
    assert _add_counts(counter, 3, 5) == 102

from __future__ import annotations

from drivers.serial.boards.devices import CountAccumulator
from robotcore.hal.devices import Angle


def _counted(counter: CountAccumulator, *counts: float) -> float:
    for count in counts:
        counter.count(count, 0.0)
    angle = counter.angle(1.0)
    assert angle
    return angle.angle


def test_angles_begin_at_zero_for_any_first_count() -> None:
    assert _counted(CountAccumulator(), 700) == 0
    assert _counted(CountAccumulator(), 700, 690) == -10


def test_before_the_first_count_there_is_no_angle() -> None:
    assert CountAccumulator().angle(1.0) is None


def test_a_counter_that_wraps_goes_on_both_ways() -> None:
    assert _counted(CountAccumulator(2**32), 2**31 - 5, -(2**31) + 5) == 10
    assert _counted(CountAccumulator(2**32), -(2**31) + 5, 2**31 - 5) == -10


def test_a_board_that_was_reset_goes_on_from_the_last_angle() -> None:
    counter = CountAccumulator()
    assert _counted(counter, 0, 100) == 100
    counter.restart()
    assert counter.angle(1.0) == Angle(100.0, 0.0, 1)
    assert _counted(counter, 3, 5) == 102

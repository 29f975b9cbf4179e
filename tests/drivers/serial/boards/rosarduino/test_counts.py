from __future__ import annotations

import pytest

from drivers.serial.boards.rosarduino.counts import Counts


def counted(*counts: tuple[float, int]) -> float | None:
    """Return what is made of counts at their times."""
    wheel = Counts()
    for time, count in counts:
        wheel.take(count, time)
    angle = wheel.turning.angle(1.0)
    return angle.angle if angle else None


@pytest.mark.parametrize(
    "counts, turned",
    [
        ([(0.0, 7)], 0),
        ([(0.0, 7), (0.01, 30)], 23),
        ([(0.0, 2**31 - 1), (0.01, -(2**31) + 4)], 5),
        ([(0.0, -(2**31)), (0.01, 2**31 - 5)], -5),
        ([(0.0, 1234), (0.005, 134), (0.01, 1236)], 2),
        ([(0.0, 1234), (0.005, 134)], 0),
        ([(0.0, 1234), (0.01, 1240), (0.3, 2), (0.31, 9)], 13),
        ([(0.0, 1234), (0.3, 1300)], 66),
        ([(0.0, 100_000), (0.01, 20), (0.02, 25)], 0),
        ([(0.0, 100_000), (0.01, 20), (0.02, 25), (0.03, 30)], 5),
    ],
    ids=["first", "on", "wraps up", "wraps down", "lost digit", "not confirmed", "reset", "pause", "anew", "goes on"],
)
def test_what_a_wheel_has_turned(counts: list[tuple[float, int]], turned: float) -> None:
    assert counted(*counts) == turned


def test_a_count_that_is_not_believed_is_no_new_sample() -> None:
    wheel = Counts()
    wheel.take(1234, 0.0)
    wheel.take(134, 0.005)
    angle = wheel.turning.angle(1.0)
    assert angle is not None
    assert (angle.time, angle.sequence) == (0.0, 0)

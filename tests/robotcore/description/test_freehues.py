from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robotcore.description.freehues import free_arcs, hue_at

HUES = st.lists(st.floats(-60, 420), min_size=1, max_size=4)


def apart(one: float, other: float) -> float:
    return abs((one - other + 180) % 360 - 180)


@given(HUES, st.floats(0, 170), st.floats(0, 1))
def test_a_hue_keeps_the_gap_to_each_that_is_taken(taken: list[float], gap: float, share: float) -> None:
    arcs = free_arcs(taken, gap)
    assume(arcs)
    hue = hue_at(arcs, share)
    assert min(apart(hue, other) for other in taken) >= gap - 1e-9


@given(HUES, st.floats(0, 170), st.integers(0, 359))
def test_every_hue_that_keeps_the_gap_is_in_an_arc(taken: list[float], gap: float, hue: int) -> None:
    assume(min(apart(hue, other) for other in taken) > gap + 1e-9)
    assert any((hue - start) % 360 <= length for start, length in free_arcs(taken, gap))


def test_shares_go_evenly_through_the_arcs() -> None:
    arcs = free_arcs([-10, 150], 60)
    assert arcs == [(210, 80), (410, 40)]
    assert [hue_at(arcs, share) for share in (0, 0.5, 0.75, 1)] == [210, 270, 420, 450]


def test_nothing_taken_leaves_the_whole_circle() -> None:
    assert hue_at(free_arcs([], 60), 0.5) == 180


@pytest.mark.parametrize("taken, gap", [([0, 120, 240], 60), ([10, -170], 90)])
def test_there_may_be_no_hue_left(taken: list[float], gap: float) -> None:
    assert free_arcs(taken, gap) == []

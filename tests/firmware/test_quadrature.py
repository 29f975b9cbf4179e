from __future__ import annotations

from itertools import accumulate

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.firmware.host import Firmware

AHEAD = (0b00, 0b10, 0b11, 0b01)
"""The levels of the channels A and B while A leads: a Gray code, which changes one bit in each step."""


@pytest.mark.parametrize("start", range(4))
def test_edges_count_up_if_a_leads_and_down_if_b_leads(firmware: Firmware, start: int) -> None:
    wheel = [AHEAD[(start + step) % 4] for step in range(4 * 240 + 1)]
    assert firmware.count_edges(wheel) == 960
    assert firmware.count_edges(reversed(wheel)) == -960


def test_unchanged_levels_are_not_counted(firmware: Firmware) -> None:
    assert firmware.count_edges([0b10] * 50 + [0b11] * 50) == 1


def test_edge_that_chatters_counts_once(firmware: Firmware) -> None:
    assert firmware.count_edges([0b00, *[0b10, 0b00] * 20, 0b10]) == 1


def test_simultaneous_change_of_both_levels_is_not_counted(firmware: Firmware) -> None:
    assert firmware.count_edges([0b00, 0b11]) == firmware.count_edges([0b10, 0b01]) == 0


@given(steps=st.lists(st.sampled_from([-1, 0, 1]), max_size=200))
def test_count_is_the_position_of_the_wheel_after_any_path(firmware: Firmware, steps: list[int]) -> None:
    places = list(accumulate(steps, initial=0))
    assert firmware.count_edges(AHEAD[place % 4] for place in places) == places[-1]

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.firmware.host import Firmware

WRAP = 2**32
"""The value at which millis() returns to 0, after 49.7 days."""

_times = st.one_of(st.integers(0, WRAP - 1), st.integers(WRAP - 3000, WRAP - 1))


@pytest.mark.slow
@given(fed=_times, limit=st.integers(100, 5000))
def test_deadman_expires_exactly_at_its_limit_even_if_the_clock_wraps(firmware: Firmware, fed: int, limit: int) -> None:
    deadman = firmware.deadman(limit)
    deadman.feed(fed)
    assert [deadman.has_expired(fed + after) for after in (0, 1, limit - 1, limit, limit + 1)] == [
        False, False, False, True, True,
    ]  # fmt: skip


@pytest.mark.parametrize("now", [0, 5000, WRAP - 1])
def test_deadman_does_not_expire_before_it_is_fed(firmware: Firmware, now: int) -> None:
    assert not firmware.deadman(100).has_expired(now)


def test_feeding_the_deadman_restarts_its_limit(firmware: Firmware) -> None:
    deadman = firmware.deadman(300)
    deadman.feed(WRAP - 200)
    deadman.feed(50)
    assert not deadman.has_expired(349)
    assert deadman.has_expired(350)


def test_disarmed_deadman_does_not_expire_until_it_is_fed(firmware: Firmware) -> None:
    deadman = firmware.deadman(300)
    deadman.feed(0)
    deadman.disarm()
    assert not deadman.has_expired(10_000)
    deadman.feed(20_000)
    assert deadman.has_expired(20_300)

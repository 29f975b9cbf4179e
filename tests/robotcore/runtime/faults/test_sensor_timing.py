from __future__ import annotations

import math

import pytest

from robotcore.kinds.range_sensor import Range
from tests.robotcore.fakes import Rig
from tests.robotcore.runtime.faults.rigs import TICK_S, build_rig


def times(rig: Rig, ticks: int) -> list[int]:
    """Read the range sensor in each of the next ticks, and return the samples' times in ticks."""
    found = []
    for _ in range(ticks):
        found.append(round(rig.robot.range.read().time / TICK_S))
        rig.sleep(TICK_S)
    return found


class TestDrop:
    def test_read_of_a_dropped_sample_returns_the_last_sample(self) -> None:
        rig = build_rig("range drop=1 after=0.1 lasts=0.1")
        rig.nose.distance = 1.0
        samples = []
        for _ in range(6):
            samples.append(rig.robot.range.read())
            rig.sleep(TICK_S)
        assert samples[1] is samples[2] is samples[3]
        assert [round(sample.time / TICK_S) for sample in samples] == [0, 1, 1, 1, 4, 5]

    @pytest.mark.parametrize("probability", [0.0, 0.2, 0.7])
    def test_share_of_dropped_samples_is_the_probability(self, probability: float) -> None:
        found = times(build_rig(f"range drop={probability}"), 1000)
        assert len(set(found)) == pytest.approx(1000 * (1 - probability), abs=45)

    def test_dropped_samples_do_not_depend_on_reads(self) -> None:
        read, unread = build_rig("range drop=0.5"), build_rig("range drop=0.5")
        for ticks in (3, 4, 5, 6, 7):
            expected = times(read, ticks)[-1]
            unread.sleep(TICK_S)
            for _ in range(ticks - 2):
                unread.sleep(TICK_S)
            assert times(unread, 1) == [expected]

    def test_random_draws_depend_on_seed_device_and_fault_index(self) -> None:
        base = times(build_rig("range drop=0.5"), 30)
        assert times(build_rig("range drop=0.5"), 30) == base
        assert times(build_rig("range drop=0.5", seed=2), 30) != base
        assert times(build_rig("eye drop=0.5", "range drop=0.5"), 30) != base


class TestReadsInEachTick:
    def test_only_a_device_with_a_fault_is_read_in_each_tick(self) -> None:
        rig, other = build_rig("range drop=0.5"), build_rig("eye drop=0.5")
        for each in (rig, other):
            each.sleep(TICK_S)
            each.sleep(TICK_S)
        assert (rig.nose.reads, other.nose.reads) == (2, 0)


class TestFreeze:
    def test_reads_return_the_last_sample_before_the_freeze_even_if_unread(self) -> None:
        rig = build_rig("range freeze after=0.2 lasts=0.3")
        for _ in range(6):
            rig.sleep(TICK_S)
        assert times(rig, 6) == [3, 3, 3, 3, 10, 11]

    def test_freeze_from_the_start_keeps_the_first_sample(self) -> None:
        assert times(build_rig("range freeze"), 3) == [0, 0, 0]


class TestNoEcho:
    def test_reads_return_the_last_sample_and_not_inf(self) -> None:
        rig = build_rig("range no_echo=1 after=0.05")
        rig.nose.distance = 0.7
        first = rig.robot.range.read()
        rig.sleep(TICK_S)
        rig.nose.distance = math.inf
        assert rig.robot.range.read() is first


class TestDelay:
    def test_samples_are_late_by_the_delay(self) -> None:
        assert times(build_rig("range delay=0.15"), 7) == [0, 0, 0, 0, 1, 2, 3]

    def test_times_do_not_decrease_at_the_start_or_the_end_of_the_fault(self) -> None:
        assert times(build_rig("range delay=0.1 after=0.2 lasts=0.2"), 10) == [0, 1, 2, 3, 3, 3, 4, 5, 8, 9]

    def test_slow_sensor_keeps_its_own_samples(self) -> None:
        rig = build_rig("range delay=0.1")
        rig.nose._newest = lambda: Range(1.0, 0.1 * (rig.clock.now() // 0.0999), 0)  # type: ignore[method-assign]
        assert times(rig, 8) == [0, 0, 0, 0, 2, 2, 4, 4]

from __future__ import annotations

import numpy as np
import pytest

from robotcore.runtime.tick_statistics import BATCH, PhaseTimes, TickStatistics


def _add_decisions(seconds: np.ndarray) -> TickStatistics:
    statistics = TickStatistics()
    for each in seconds.tolist():
        statistics.add(PhaseTimes(0.0, each, 0.0, 0.0, 0.0, 0.0))
    return statistics


@pytest.mark.parametrize("ticks", [1, 2, 99, BATCH - 1, BATCH, 3 * BATCH + 7])
def test_percentiles_are_those_of_all_ticks(ticks: int) -> None:
    seconds = 10 ** np.random.default_rng(ticks).uniform(-6, 1, ticks)
    found = _add_decisions(seconds).summarise()["decide"]
    ordered = np.sort(seconds) * 1e6
    assert found["p50"] == pytest.approx(ordered[int(np.ceil(0.5 * ticks)) - 1], rel=0.006, abs=0.06)
    assert found["p99"] == pytest.approx(ordered[int(np.ceil(0.99 * ticks)) - 1], rel=0.006, abs=0.06)
    assert found["worst"] == pytest.approx(ordered[-1], abs=0.06)


def test_every_phase_has_its_own_durations() -> None:
    statistics = TickStatistics()
    statistics.add(PhaseTimes(0.001, 0.002, 0.003, 0.004, 0.005, 0.006))
    worst = {phase: values["worst"] for phase, values in statistics.summarise().items()}
    assert worst == {"read": 1000, "decide": 2000, "guard": 3000, "commit": 4000, "record": 5000, "sleep": 6000}


def test_before_the_first_tick_the_summary_is_empty() -> None:
    assert TickStatistics().summarise() == {}


@pytest.mark.parametrize("seconds, worst", [(0.0, 0.0), (-1e-6, 0.0), (1e5, 1e11)])
def test_durations_beyond_the_bins_are_counted(seconds: float, worst: float) -> None:
    assert _add_decisions(np.array([seconds] * 3)).summarise()["decide"]["worst"] == worst

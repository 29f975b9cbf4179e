from __future__ import annotations

from pathlib import Path
from unittest.mock import Mock

import pytest

from robotcore.safety.watchdog import FairTime

SECOND_NS = 1_000_000_000


@pytest.fixture
def time(tmp_path: Path) -> FairTime:
    """The time of a thread that is looked at every second, by a clock that a test sets."""
    fair = FairTime(0, 1.0)
    fair._file = tmp_path / "schedstat"
    fair._file.write_text("0 0 1")
    fair._wall = Mock()
    return fair


def at(fair: FairTime, seconds: float, waited: float = 0.0) -> float:
    fair._wall.now.return_value = seconds  # type: ignore[attr-defined]
    fair._file.write_text(f"5 {round(waited * SECOND_NS)} 9")
    return fair.passed()


def test_counts_the_seconds_since_it_was_last_asked(time: FairTime) -> None:
    assert at(time, 1.0) == 1.0
    assert at(time, 1.5) == 0.5


def test_does_not_count_the_wait_for_a_processor(time: FairTime) -> None:
    assert at(time, 1.0, waited=0.75) == pytest.approx(0.25)
    assert at(time, 2.0, waited=0.75) == 1.0


def test_counts_a_wait_that_is_told_late_for_as_long_as_it_was(time: FairTime) -> None:
    assert at(time, 1.0, waited=1.5) == 0.0
    assert at(time, 2.0, waited=1.5) == pytest.approx(0.5)


def test_does_not_count_for_how_long_whoever_looks_was_held_up(time: FairTime) -> None:
    assert at(time, 100.0) == 2.0


def test_counts_all_where_the_system_does_not_tell(time: FairTime, tmp_path: Path) -> None:
    time._file = tmp_path / "missing" / "schedstat"
    time._wall.now.return_value = 1.0  # type: ignore[attr-defined]
    assert time.passed() == 1.0

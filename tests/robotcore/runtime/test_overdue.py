from __future__ import annotations

import sys

from robotcore.errors import BackendError, WatchdogError
from robotcore.runtime.time_limits import judging
from tests.robotcore.fakes import Deed


class Judge(Deed):
    """An app of this file."""


def test_a_judge_that_hangs_is_named_by_its_line() -> None:
    error = judging(Judge(lambda _: None), "rig").error(10.0, sys._getframe())
    assert isinstance(error, WatchdogError)
    assert str(error).startswith("Judge has not come back from verify for 10.0 s, at test_overdue.py:")


def test_a_simulator_that_does_not_tell_the_truth_is_named() -> None:
    error = judging(Judge(lambda _: None), "rig").error(10.0, None)
    assert isinstance(error, BackendError)
    assert "'rig' has not told the truth" in str(error)

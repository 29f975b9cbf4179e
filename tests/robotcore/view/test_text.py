"""Texts about results of runs."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from robotcore import Outcome, RunResult
from robotcore.view.text import format_heading, format_summary, list_measures
from tests.texts import CheckText

HELD = {"acceleration limit": 3.0, "range guard": 15.0, "velocity limit": 2.0, "lost device": 0.499, "deadman": 0.5}
FAULTS = ["camera drop=0.2 after=5", "left_motor weak=0.6", "camera freeze after=60"]


@pytest.mark.parametrize(
    "changes",
    [
        {"verified": False},
        {"verified": None},
        {"judge": "green-search"},
        {"verified": False, "judge": "green-search"},
        {"contacts": 0},
        {"contacts": 1},
        {"contacts": 2},
        {"batteries": {"cells": {"lowest_v": 6.912, "last_v": 7.2}}},
        {"outcome": Outcome.TIMEOUT, "verified": False, "reason": "not done after 120 s"},
        {"intervention_s": HELD, "sim_time_s": 30.0},
        {"intervention_s": {"velocity limit": 4.0}, "sim_time_s": 4.05},
        {"faults": FAULTS, "sim_time_s": 5.0},
        {"contacts": 1, "distance_to_target_m": 0.281, "sim_time_s": 30.0, "wall_time_s": 0.5},
    ],
    ids=", ".join,
)
def test_a_summary_has_the_verdict_and_what_is_known(
    result: RunResult, check_text: CheckText, changes: dict[str, Any]
) -> None:
    check_text(format_summary(dataclasses.replace(result, **changes)).plain)


def test_a_disputed_success_is_not_green(result: RunResult) -> None:
    agreed, disputed = (format_summary(dataclasses.replace(result, verified=verified)) for verified in (True, False))
    assert ("green" in str(agreed.spans), "green" in str(disputed.spans)) == (True, False)


def test_a_heading_has_the_world_and_the_seed_if_there_are_any(result: RunResult, check_text: CheckText) -> None:
    check_text("\n".join(list_measures(result)))
    check_text(format_heading(result))
    check_text(format_heading(dataclasses.replace(result, world=None, seed=None)))

"""test_text."""

from __future__ import annotations

import dataclasses

import pytest

from robotcore import Outcome, RunResult
from robotcore.view.text import format_heading, format_summary, list_measures


@pytest.mark.parametrize(
    "verified, judge, words",
    [
        (True, None, "verified by the simulator"),
        (False, None, "the simulator does not agree"),
        (True, "green-search", "verified by the judge"),
        (False, "green-search", "the judge does not agree"),
    ],
)
def test_a_success_is_reported_with_the_word_of_who_judges(
    result: RunResult, *, verified: bool, judge: str | None, words: str
) -> None:
    assert words in format_summary(dataclasses.replace(result, verified=verified, judge=judge)).plain


def test_a_success_that_is_disputed_is_not_green(result: RunResult) -> None:
    agreed, disputed = (format_summary(dataclasses.replace(result, verified=verified)) for verified in (True, False))
    assert ("green" in str(agreed.spans), "green" in str(disputed.spans)) == (True, False)


def test_a_success_that_nobody_can_verify_is_reported_without_a_verdict(result: RunResult) -> None:
    shown_states = format_summary(dataclasses.replace(result, verified=None)).plain
    assert "verified" not in shown_states
    assert "agree" not in shown_states


def test_the_voltages_of_a_battery_are_reported(result: RunResult) -> None:
    shown_states = dataclasses.replace(result, batteries={"cells": {"lowest_v": 6.912, "last_v": 7.2}})
    assert "cells at 7.20 V, at its lowest 6.91 V" in format_summary(shown_states).plain


def test_a_timeout_needs_no_verdict_but_a_reason(result: RunResult) -> None:
    shown_states = dataclasses.replace(result, outcome=Outcome.TIMEOUT, verified=False, reason="not done after 120 s")
    lines = format_summary(shown_states).plain.splitlines()
    assert lines[0].startswith("timeout")
    assert "simulator" not in lines[1]
    assert lines[-1] == "  not done after 120 s"


def test_what_nobody_knows_is_left_out(result: RunResult) -> None:
    assert list(list_measures(result)) == ["verified by the simulator", "0.0 s at 0.0x real time"]
    known = dataclasses.replace(result, contacts=1, distance_to_target_m=0.281, sim_time_s=30.0, wall_time_s=0.5)
    assert list(list_measures(known))[1:] == ["30.0 s at 60x real time", "0.28 m from the target", "1 contact"]


def test_the_heading_names_world_and_seed_only_where_there_are_any(result: RunResult) -> None:
    assert format_heading(result) == "green-search on kinematic, arena, seed 7"
    assert format_heading(dataclasses.replace(result, world=None, seed=None)) == "green-search on kinematic"


def test_milestones_are_reported_with_their_times(result: RunResult) -> None:
    assert "search at 0.0 s, seen at 0.5 s, approach at 1.0 s, arrived at 1.5 s" in format_summary(result).plain


def test_faults_on_purpose_are_reported_apart_from_those_that_never_began(result: RunResult) -> None:
    faults = ["camera drop=0.2 after=5", "left_motor weak=0.6", "camera freeze after=60"]
    lines = format_summary(dataclasses.replace(result, faults=faults, sim_time_s=5.0)).plain.splitlines()
    assert lines[-2:] == [
        "  with faults: camera drop=0.2 after=5; left_motor weak=0.6",
        "  ended before: camera freeze after=60",
    ]
    assert "fault" not in format_summary(result).plain

"""Texts about results of runs."""

from __future__ import annotations

import dataclasses

import pytest

from robotcore import Outcome, RunResult
from robotcore.view.text import format_heading, format_summary, list_measures
from tests.texts import CheckText


@pytest.mark.parametrize(
    "verified, judge", [(True, None), (False, None), (None, None), (True, "green-search"), (False, "green-search")]
)
def test_a_summary_has_the_verdict_of_the_judge(
    result: RunResult, check_text: CheckText, *, verified: bool | None, judge: str | None
) -> None:
    check_text(format_summary(dataclasses.replace(result, verified=verified, judge=judge)).plain)


def test_a_disputed_success_is_not_green(result: RunResult) -> None:
    agreed, disputed = (format_summary(dataclasses.replace(result, verified=verified)) for verified in (True, False))
    assert ("green" in str(agreed.spans), "green" in str(disputed.spans)) == (True, False)


def test_a_summary_has_the_voltages_of_a_battery(result: RunResult, check_text: CheckText) -> None:
    with_battery = dataclasses.replace(result, batteries={"cells": {"lowest_v": 6.912, "last_v": 7.2}})
    check_text(format_summary(with_battery).plain)


def test_the_summary_of_a_timeout_has_its_reason_and_no_verdict(result: RunResult, check_text: CheckText) -> None:
    timeout = dataclasses.replace(result, outcome=Outcome.TIMEOUT, verified=False, reason="not done after 120 s")
    check_text(format_summary(timeout).plain)


def test_unknown_measurements_are_left_out(result: RunResult, check_text: CheckText) -> None:
    check_text("\n".join(list_measures(result)))
    known = dataclasses.replace(result, contacts=1, distance_to_target_m=0.281, sim_time_s=30.0, wall_time_s=0.5)
    check_text("\n".join(list_measures(known)))


def test_a_summary_begins_with_the_contacts_if_there_are_any(result: RunResult, check_text: CheckText) -> None:
    for contacts in (0, 1, 2):
        check_text(format_summary(dataclasses.replace(result, contacts=contacts)).plain)


def test_a_summary_names_interventions_and_their_durations(result: RunResult, check_text: CheckText) -> None:
    held = {"acceleration limit": 3.0, "range guard": 15.0, "velocity limit": 2.0, "lost device": 0.499, "deadman": 0.5}
    check_text(format_summary(dataclasses.replace(result, intervention_s=held)).plain)


def test_a_summary_is_silent_about_limits_and_short_interventions(result: RunResult) -> None:
    short = {"acceleration limit": 3.0, "velocity limit": 2.0, "range guard": 0.45}
    assert format_summary(dataclasses.replace(result, intervention_s=short)) == format_summary(result)


def test_a_heading_has_the_world_and_the_seed_if_there_are_any(result: RunResult, check_text: CheckText) -> None:
    check_text(format_heading(result))
    check_text(format_heading(dataclasses.replace(result, world=None, seed=None)))


def test_a_summary_lists_faults_that_began_and_those_that_did_not(result: RunResult, check_text: CheckText) -> None:
    faults = ["camera drop=0.2 after=5", "left_motor weak=0.6", "camera freeze after=60"]
    check_text(format_summary(dataclasses.replace(result, faults=faults, sim_time_s=5.0)).plain)

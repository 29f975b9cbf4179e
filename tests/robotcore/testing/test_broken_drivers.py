"""The conformance kit on broken drivers: each fails its own rules and no others."""

from __future__ import annotations

import pytest

from tests.robotcore.testing.broken import BROKEN
from tests.robotcore.testing.broken.devices import BatterySuite
from tests.robotcore.testing.harness import Broken, Sound, find_failing_rules, list_rules


def test_sound_driver_fails_no_rule() -> None:
    assert find_failing_rules(Sound) == set()


def test_sound_driver_with_a_battery_fails_no_rule() -> None:
    assert find_failing_rules(BatterySuite) == set()


@pytest.mark.parametrize("broken", BROKEN, ids=[broken.problem for broken in BROKEN])
def test_broken_driver_fails_its_own_rules_and_no_others(broken: Broken) -> None:
    assert find_failing_rules(broken.suite) == broken.rules


def test_every_rule_is_failed_by_a_broken_driver() -> None:
    assert set().union(*(broken.rules for broken in BROKEN)) == list_rules()


def test_robot_without_a_drive_fails_no_rule() -> None:
    class Lookout(Sound):
        robot = "lookout"

    assert find_failing_rules(Lookout) == set()

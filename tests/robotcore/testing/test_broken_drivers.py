"""The conformance kit on broken drivers: each fails its own rules and no others."""

from __future__ import annotations

import pytest

from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite
from tests.robotcore.testing.broken import BROKEN
from tests.robotcore.testing.broken.devices import BatterySuite
from tests.robotcore.testing.broken.unmeasured import (
    MeasuredSuite,
    MeasuredWithoutEncodersSuite,
    NoTruthSuite,
    UnmeasuredSuite,
)
from tests.robotcore.testing.harness import Broken, Sound, find_failing_rules, list_rules

MOTION_RULES = {
    "positive_velocity_drives_forward",
    "left_motor_faster_turns_right",
    "velocity_is_in_radians_per_second",
    "stop_brings_the_wheels_to_rest",
}


def test_sound_driver_fails_no_rule() -> None:
    assert find_failing_rules(Sound) == set()


def test_sound_driver_with_a_battery_fails_no_rule() -> None:
    assert find_failing_rules(BatterySuite) == set()


@pytest.mark.parametrize("broken", BROKEN, ids=[broken.problem for broken in BROKEN])
def test_broken_driver_fails_its_own_rules_and_no_others(broken: Broken) -> None:
    assert find_failing_rules(broken.suite) == broken.rules


def test_every_rule_is_failed_by_a_broken_driver() -> None:
    assert set().union(*(broken.rules for broken in BROKEN)) == list_rules()


@pytest.mark.parametrize("suite", [NoTruthSuite, MeasuredSuite, MeasuredWithoutEncodersSuite, UnmeasuredSuite])
def test_sound_robot_without_truth_fails_no_rule(suite: type[ConformanceSuite]) -> None:
    assert find_failing_rules(suite) == set()


@pytest.mark.parametrize("suite", [MeasuredSuite, MeasuredWithoutEncodersSuite])
@pytest.mark.parametrize("rule", sorted(MOTION_RULES))
def test_measured_pose_lets_the_rules_for_motion_run(suite: type[ConformanceSuite], rule: str) -> None:
    getattr(suite(), f"test_{rule}")()


@pytest.mark.parametrize("rule", sorted(MOTION_RULES))
def test_truth_has_precedence_over_the_measured_pose(rule: str) -> None:
    class Suite(Sound):
        def measure_pose(self, robot: Robot) -> Pose:
            raise NotImplementedError

    getattr(Suite(), f"test_{rule}")()


@pytest.mark.parametrize("rule", sorted(MOTION_RULES))
def test_rules_for_motion_are_skipped_if_nothing_measures_it(rule: str) -> None:
    with pytest.raises(pytest.skip.Exception, match="nothing measures the robot's motion"):
        getattr(UnmeasuredSuite(), f"test_{rule}")()


def test_robot_without_a_drive_fails_no_rule() -> None:
    class Lookout(Sound):
        robot = "lookout"

    assert find_failing_rules(Lookout) == set()

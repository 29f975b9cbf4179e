"""The conformance kit on broken drivers: each fails its own rules and no others."""

from __future__ import annotations

import pytest

from robotcore.errors import DeviceError
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite
from tests.robotcore.testing.broken import BROKEN
from tests.robotcore.testing.broken.cutoffs import CutoffSuite
from tests.robotcore.testing.broken.devices import BatterySuite
from tests.robotcore.testing.broken.kinds import EquippedSuite
from tests.robotcore.testing.broken.unmeasured import (
    MeasuredSuite,
    MeasuredWithoutEncodersSuite,
    NoTruthSuite,
    UnmeasuredSuite,
)
from tests.robotcore.testing.broken.unplugged import UnpluggedSuite
from tests.robotcore.testing.harness import Broken, Sound, find_failing_rules, list_rules

MOTION_RULES = {
    "positive_velocity_drives_forward",
    "left_motor_faster_turns_right",
    "wheels_turn_at_the_commanded_velocity",
    "stop_brings_the_wheels_to_rest",
}


class Lookout(Sound):
    """The suite on a robot without a drive."""

    robot = "lookout"


class TruthSuite(Sound):
    """A suite that must not measure the pose, because the robot has truth."""

    def measure_pose(self, robot: Robot) -> Pose:
        raise NotImplementedError


SOUND = (
    EquippedSuite,
    Sound,
    BatterySuite,
    CutoffSuite,
    Lookout,
    NoTruthSuite,
    MeasuredSuite,
    MeasuredWithoutEncodersSuite,
    UnmeasuredSuite,
    UnpluggedSuite,
)


@pytest.mark.slow
@pytest.mark.parametrize("suite", SOUND)
def test_sound_driver_fails_no_rule(suite: type[ConformanceSuite]) -> None:
    assert find_failing_rules(suite) == set()


@pytest.mark.slow
@pytest.mark.parametrize("broken", BROKEN, ids=[broken.problem for broken in BROKEN])
def test_broken_driver_fails_its_own_rules_and_no_others(broken: Broken) -> None:
    assert find_failing_rules(broken.suite) == broken.rules


def test_every_rule_is_failed_by_a_broken_driver() -> None:
    assert set().union(*(broken.rules for broken in BROKEN)) == list_rules()


def test_command_that_fails_before_the_hardware_is_unplugged_passes_no_rule() -> None:
    class FailingSuite(UnpluggedSuite):
        def command_wheels(self, robot: Robot, left: float, right: float, seconds: float = 0.0) -> None:
            raise DeviceError("left_motor", "no answer")

    with pytest.raises(DeviceError):
        FailingSuite().test_closing_unplugged_hardware_is_an_error()


@pytest.mark.parametrize("suite", [TruthSuite, MeasuredSuite, MeasuredWithoutEncodersSuite])
@pytest.mark.parametrize("rule", sorted(MOTION_RULES))
def test_rules_for_motion_use_the_truth_or_the_measured_pose(suite: type[ConformanceSuite], rule: str) -> None:
    getattr(suite(), f"test_{rule}")()


@pytest.mark.parametrize("rule", sorted(MOTION_RULES))
def test_rules_for_motion_are_skipped_if_nothing_measures_it(rule: str) -> None:
    with pytest.raises(pytest.skip.Exception, match="nothing measures the robot's motion"):
        getattr(UnmeasuredSuite(), f"test_{rule}")()

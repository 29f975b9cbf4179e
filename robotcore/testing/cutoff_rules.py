"""Rules for cutoffs, with which another process stops the motors after the program was killed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import hypot

import pytest

from robotcore.hal.backend import Capability
from robotcore.hal.robot import Robot, Role
from robotcore.safety.guardian.process import stop_once
from robotcore.testing.bench import SETTLING_S, STANDSTILL_M, TestBench, TestSupport, sleep

SPEED_RAD_S = 2.0

NO_CUTOFFS = "the robot has no cutoffs. If the program of a real robot is killed, its motors may keep turning"


class CutoffRules(TestBench):
    """Tests that a driver with cutoffs must pass."""

    def test_cutoffs_bring_the_wheels_to_rest(self) -> None:
        self.require(TestSupport.MOTION, TestSupport.CUTOFFS)
        with self._open_with_cutoffs() as robot:
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
            report = stop_once(robot.cutoffs)
            assert not report.failed, (
                f"the cutoffs failed: {'; '.join(report.failed)}. Correct them. "
                "If they cannot reach the fake hardware, name TestSupport.CUTOFFS in lacks"
            )
            if not report.done:
                pytest.skip(f"the cutoffs cannot confirm a stop of an open robot: {'; '.join(report.messages)}")
            sleep(robot, SETTLING_S)
            motion = self.measure_motion(robot, SETTLING_S)
            moved_m = hypot(motion.forward, motion.left) + abs(motion.turn) * self.drive.track_m / 2
        assert moved_m < STANDSTILL_M, (
            f"the cutoffs reported a stop of {', '.join(report.done)}, and {SETTLING_S} s later the wheels still moved "
            f"{moved_m:.3f} m in {SETTLING_S} s. Let the cutoffs stop every motor of the drive"
        )

    def test_robotcore_stop_has_the_cutoffs_of_a_run(self) -> None:
        with self._open_with_cutoffs() as robot:
            expected = sorted(spec.device for spec in robot.cutoffs)
        if Capability.POSE in self.backend.capabilities:
            pytest.skip("the motors of a simulator end with it, so `robotcore stop` needs no cutoffs")
        found = sorted(spec.device for spec in self.backend().cutoffs(self.build_setup()))
        assert found == expected, (
            f"a run has cutoffs of {expected}, and Backend.cutoffs(setup) returns those of {found}. "
            "Return the same ones, because `robotcore stop` stops the motors with them"
        )

    @contextmanager
    def _open_with_cutoffs(self) -> Iterator[Robot]:
        with self.open_robot(None, Role.DRIVE) as robot:
            if not robot.cutoffs:
                pytest.skip(NO_CUTOFFS)
            yield robot

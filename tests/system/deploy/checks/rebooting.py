"""Shutdowns and power cuts of the robot, also during a health check."""

from __future__ import annotations

import pytest

from tests.system.deploy.rover import Ran, Rover
from tests.system.speed import scaled

LIMIT_S = 120
"""The time limit for the rest of a push on the reference machine, in s."""

RAD_S, NEW_RAD_S = 2.0, 3.0


@pytest.mark.parametrize("way", ["shut_down", "cut_power"])
def test_release_drives_again_after_a_boot(rover: Rover, way: str) -> None:
    rover.run("start")
    release = rover.release
    rover.motors.await_driving(RAD_S)
    getattr(rover.machine, way)()
    rover.motors.mark()
    rover.machine.boot()
    rover.motors.await_driving(RAD_S)
    assert (rover.release, rover.status()["state"]) == (release, "running")


def test_stopped_app_stays_stopped(rover: Rover) -> None:
    rover.run("stop")
    rover.machine.shut_down()
    rover.machine.boot()
    assert (rover.status()["state"], rover.process, rover.motors.are_stopped()) == ("stopped", 0, True)


def test_interrupted_health_check_begins_again_and_keeps_a_healthy_release(rover: Rover) -> None:
    rover.run("start")
    rover.motors.await_driving(RAD_S)
    before = rover.release
    done = push_and_cut_power(rover, f"speed_rad_s={NEW_RAD_S:g}")
    assert (done.returncode, rover.release > before) == (0, True), done.stderr
    rover.motors.await_driving(NEW_RAD_S)
    rover.run("rollback", before)


def test_interrupted_health_check_begins_again_and_rolls_back_a_failing_release(rover: Rover) -> None:
    rover.run("start")
    rover.motors.await_driving(RAD_S)
    before = rover.release
    done = push_and_cut_power(rover, f"speed_rad_s={NEW_RAD_S:g}", "fault=raise", "at=40")
    assert (done.returncode, rover.release) == (1, before), done.stderr
    assert "no ball today" in done.stderr
    rover.motors.await_driving(RAD_S)


def push_and_cut_power(rover: Rover, *settings: str) -> Ran:
    """Push a release, cut the power once it drives, and boot the robot; return the result of the push."""
    options = [word for setting in settings for word in ("--set", setting)]
    with rover.run_push(*options) as push:
        rover.motors.await_driving(NEW_RAD_S)
        assert (rover.files / "health-check.json").exists()
        rover.machine.cut_power()
        rover.motors.mark()
        rover.machine.boot()
        out, err = push.communicate(timeout=scaled(LIMIT_S))
        return Ran(push.args, push.returncode, out, err)

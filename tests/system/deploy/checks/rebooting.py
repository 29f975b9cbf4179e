"""The robot is switched off, in good order or not, also while a new release has yet to prove itself."""

from __future__ import annotations

import pytest

from tests.system.deploy.rover import Ran, Rover
from tests.system.speed import scaled

LIMIT_S = 120
"""Of what is left of a push, on the reference machine: a hang."""

RAD_S, NEW_RAD_S = 2.0, 3.0


@pytest.mark.parametrize("way", ["shut_down", "cut_power"])
def test_release_that_drove_drives_again(rover: Rover, way: str) -> None:
    rover.done("start")
    release = rover.release
    rover.motors.await_driving(RAD_S)
    getattr(rover.machine, way)()
    rover.motors.mark()
    rover.machine.boot()
    rover.motors.await_driving(RAD_S)
    assert (rover.release, rover.status()["state"]) == (release, "running")


def test_stopped_app_stays_stopped(rover: Rover) -> None:
    rover.done("stop")
    rover.machine.shut_down()
    rover.machine.boot()
    assert (rover.status()["state"], rover.process, rover.motors.is_still()) == ("stopped", 0, True)


def test_release_on_trial_is_judged_again_and_kept_if_it_lives(rover: Rover) -> None:
    rover.done("start")
    rover.motors.await_driving(RAD_S)
    before = rover.release
    ran = pushed_while_power_is_cut(rover, f"speed_rad_s={NEW_RAD_S:g}")
    assert (ran.returncode, rover.release > before) == (0, True), ran.stderr
    rover.motors.await_driving(NEW_RAD_S)
    rover.done("rollback", before)


def test_release_on_trial_is_judged_again_and_rolled_back_if_it_does_not_live(rover: Rover) -> None:
    rover.done("start")
    rover.motors.await_driving(RAD_S)
    before = rover.release
    ran = pushed_while_power_is_cut(rover, f"speed_rad_s={NEW_RAD_S:g}", "fault=raise", "at=40")
    assert (ran.returncode, rover.release) == (1, before), ran.stderr
    assert "no ball today" in ran.stderr
    rover.motors.await_driving(RAD_S)


def pushed_while_power_is_cut(rover: Rover, *settings: str) -> Ran:
    """Push a release, and cut the power once it drives; the desk waits until the robot is there again."""
    options = [word for setting in settings for word in ("--set", setting)]
    with rover.pushing(*options) as push:
        rover.motors.await_driving(NEW_RAD_S)
        assert (rover.files / "trial.json").exists()
        rover.machine.cut_power()
        rover.motors.mark()
        rover.machine.boot()
        out, err = push.communicate(timeout=scaled(LIMIT_S))
        return Ran(push.args, push.returncode, out, err)

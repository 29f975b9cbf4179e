"""Each way in which a release can be broken: the one before runs again, and the reason is told."""

from __future__ import annotations

import time

import pytest

from tests.system.deploy.motors import awaited
from tests.system.deploy.rover import SERVICE, Ran, Rover, with_text

RAD_S, BROKEN_RAD_S = 2.0, 7.0
SOON = ("--healthy-within", "6")
APP = "drive_ahead.py"
FAULTS = {
    "raises at once": (("fault=raise",), "no ball today"),
    "raises while it is looked at": (("fault=raise", "at=30"), "no ball today"),
    "leaves without a word": (("fault=exit",), "9"),
    "hangs in its first step": (("fault=hang",), ""),
    "does not come up": (("fault=no-start",), "6 s"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_release_that_does_not_live_is_rolled_back_with_its_reason(rover: Rover, fault: str) -> None:
    settings, reason = FAULTS[fault]
    options = [word for setting in (f"speed_rad_s={BROKEN_RAD_S:g}", *settings) for word in ("--set", setting)]
    require_rolled_back(rover, reason, *options)


@pytest.mark.parametrize(
    "line, reason", [("import nowhere_to_be_found", "nowhere_to_be_found"), ("def (:", "SyntaxError")]
)
def test_app_that_python_does_not_take_is_rolled_back_with_its_reason(rover: Rover, line: str, reason: str) -> None:
    app = rover.project / APP
    with with_text(app, f"{app.read_text()}\n{line}\n"):
        require_rolled_back(rover, reason)


def require_rolled_back(rover: Rover, reason: str, *arguments: str) -> None:
    """Push what does not live; the release that drives now has to drive again, and the motors stood in between."""
    rover.done("start")
    driving, release = rover.motors.await_driving(RAD_S), rover.release
    ran: Ran = rover.push(*SOON, *arguments)
    assert (ran.returncode, rover.release) == (1, release), f"{ran.stdout}{ran.stderr}"
    assert reason in ran.stderr
    assert f"{release} runs again" in ran.stderr
    again = rover.motors.await_driving(RAD_S, instead_of=driving)
    assert rover.motors.stood_between(driving, again)


PAUSE_S = 2.0
"""Between the end of an app and its next start: the unit's RestartSec."""


def test_killed_app_comes_back_and_stood_in_between(rover: Rover, driving: int) -> None:
    rover.desk.ssh(f"kill -9 {driving}")
    require_another(rover, driving)


def test_app_killed_with_its_guardian_comes_back_and_stood_in_between(rover: Rover, driving: int) -> None:
    """Nobody is left on the robot but systemd, which calls what stops the motors."""
    rover.desk.ssh(f"systemctl --user kill --signal KILL {SERVICE}")
    require_another(rover, driving)


def test_app_that_hangs_in_its_own_code_comes_back_and_stood_in_between(rover: Rover, driving: int) -> None:
    rover.desk.ssh("echo hang > fault")
    require_another(rover, driving)


def test_suspended_app_is_ended_by_systemd_and_stood_all_the_while(rover: Rover, driving: int) -> None:
    rover.desk.ssh(f"kill -STOP {driving}")
    require_another(rover, driving)
    assert "watchdog" in rover.desk.ssh(f"journalctl --user --unit {SERVICE} --lines 40 --output cat").lower()


def test_app_that_the_safety_stage_stopped_stands_until_somebody_starts_it(rover: Rover, driving: int) -> None:
    rover.desk.ssh("echo invalid-speed > fault")
    awaited(lambda: None if rover.process else 1, "the end of the app", rover.status)
    time.sleep(2 * PAUSE_S)
    status = rover.status()
    assert (status["state"], status["reason"]) == ("failed", "it ended with status 4 (the safety stage stopped it)")
    assert rover.motors.is_still()


def test_stopped_app_stands_and_is_not_started_again(rover: Rover, driving: int) -> None:
    rover.done("stop")
    assert (rover.process, rover.motors.is_still()) == (0, True)
    assert rover.status()["state"] == "stopped"


def require_another(rover: Rover, driving: int) -> None:
    """Wait for another process that drives; the motors have to have stood before it did."""
    another = rover.motors.await_driving(instead_of=driving)
    assert rover.motors.stood_between(driving, another)

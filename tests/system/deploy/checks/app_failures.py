"""Failures of an app: a new release is rolled back with its reason, and a running app is restarted."""

from __future__ import annotations

import time

import pytest

from tests.system.deploy.motors import wait_for
from tests.system.deploy.rover import SERVICE, Ran, Rover, replace_text

RAD_S, BROKEN_RAD_S = 2.0, 7.0
SOON = ("--healthy-within", "6")
APP = "drive_ahead.py"
FAULTS = {
    "raises at once": (("fault=raise",), "no ball today"),
    "raises during the check": (("fault=raise", "at=30"), "no ball today"),
    "exits without a message": (("fault=exit",), "9"),
    "hangs in its first tick": (("fault=hang",), ""),
    "never starts": (("fault=no-start",), "6 s"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_failing_release_is_rolled_back_with_its_reason(rover: Rover, fault: str) -> None:
    settings, reason = FAULTS[fault]
    options = [word for setting in (f"speed_rad_s={BROKEN_RAD_S:g}", *settings) for word in ("--set", setting)]
    require_rolled_back(rover, reason, *options)


@pytest.mark.parametrize(
    "line, reason", [("import nowhere_to_be_found", "nowhere_to_be_found"), ("def (:", "SyntaxError")]
)
def test_app_that_cannot_be_imported_is_rolled_back_with_its_reason(rover: Rover, line: str, reason: str) -> None:
    app = rover.project / APP
    with replace_text(app, f"{app.read_text()}\n{line}\n"):
        require_rolled_back(rover, reason)


def require_rolled_back(rover: Rover, reason: str, *arguments: str) -> None:
    """Push a release that fails. The current one must drive again, after the motors were stopped."""
    rover.run("start")
    driving, release = rover.motors.await_driving(RAD_S), rover.release
    done: Ran = rover.push(*SOON, *arguments)
    assert (done.returncode, rover.release) == (1, release), f"{done.stdout}{done.stderr}"
    assert reason in done.stderr
    assert f"{release} runs again" in done.stderr
    again = rover.motors.await_driving(RAD_S, instead_of=driving)
    assert rover.motors.were_stopped_between(driving, again)


PAUSE_S = 2.0
"""The time between the end of an app and its restart in s, the unit's RestartSec."""


def test_killed_app_is_restarted_after_a_stop_of_the_motors(rover: Rover, driving: int) -> None:
    rover.client.ssh(f"kill -9 {driving}")
    require_restart(rover, driving)


def test_app_killed_with_its_guardian_is_restarted_after_a_stop_of_the_motors(rover: Rover, driving: int) -> None:
    """Only systemd is left, which runs the command that stops the motors."""
    rover.client.ssh(f"systemctl --user kill --signal KILL {SERVICE}")
    require_restart(rover, driving)


def test_hanging_app_is_restarted_after_a_stop_of_the_motors(rover: Rover, driving: int) -> None:
    rover.client.ssh("echo hang > fault")
    require_restart(rover, driving)


def test_suspended_app_is_killed_by_the_watchdog_of_systemd(rover: Rover, driving: int) -> None:
    rover.client.ssh(f"kill -STOP {driving}")
    require_restart(rover, driving)
    assert "watchdog" in rover.client.ssh(f"journalctl --user --unit {SERVICE} --lines 40 --output cat").lower()


def test_app_stopped_by_the_safety_stage_stays_stopped(rover: Rover, driving: int) -> None:
    rover.client.ssh("echo invalid-speed > fault")
    wait_for(lambda: None if rover.process else 1, "the end of the app", rover.status)
    time.sleep(2 * PAUSE_S)
    status = rover.status()
    assert (status["state"], status["reason"]) == ("failed", "it ended with status 4 (the safety stage stopped it)")
    assert rover.motors.are_stopped()


def test_stopped_app_is_not_restarted(rover: Rover, driving: int) -> None:
    rover.run("stop")
    assert (rover.process, rover.motors.are_stopped()) == (0, True)
    assert rover.status()["state"] == "stopped"


def require_restart(rover: Rover, driving: int) -> None:
    """Wait until another process drives. The motors must have been stopped before it."""
    another = rover.motors.await_driving(instead_of=driving)
    assert rover.motors.were_stopped_between(driving, another)

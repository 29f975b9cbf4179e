"""Whatever becomes of the app's process, the motors stand before the next one drives."""

from __future__ import annotations

import time

from tests.system.deploy.motors import awaited
from tests.system.deploy.rover import SERVICE, Rover

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
    rover.desk.ssh("echo hangs > deed")
    require_another(rover, driving)


def test_suspended_app_is_ended_by_systemd_and_stood_all_the_while(rover: Rover, driving: int) -> None:
    rover.desk.ssh(f"kill -STOP {driving}")
    require_another(rover, driving)
    assert "watchdog" in rover.desk.ssh(f"journalctl --user --unit {SERVICE} --lines 40 --output cat").lower()


def test_app_that_the_safety_stage_stopped_stands_until_somebody_starts_it(rover: Rover, driving: int) -> None:
    rover.desk.ssh("echo errs > deed")
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

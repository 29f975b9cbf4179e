"""Each step of a push, interrupted: the old release goes on, or the new one runs, and the next push goes through."""

from __future__ import annotations

import os
import signal
import subprocess

import pytest

from tests.system.deploy.rover import Rover
from tests.system.deploy.steps import STEPS, interrupted, require_either


@pytest.mark.parametrize("step", STEPS)
def test_ctrl_c(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    ran = interrupted(rover, step, lambda push: os.killpg(push.pid, signal.SIGINT))
    assert ran.returncode == -signal.SIGINT, ran.stderr
    assert ("Nothing has changed" in ran.stderr) == (step != "release"), ran.stderr
    require_either(rover, driving, before, step)


@pytest.mark.parametrize("step", ["sent", "release"])
def test_desk_is_killed(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    interrupted(rover, step, subprocess.Popen.kill)
    require_either(rover, driving, before, step)


@pytest.mark.parametrize("step", ["sent", "release"])
def test_connection_is_killed(rover: Rover, driving: int, step: str) -> None:
    """While a release is on trial, the desk connects again and tells what came of it."""
    before = rover.release
    ran = interrupted(rover, step, lambda _: rover.machine.as_root("systemctl", "kill", "--signal=KILL", "session-*"))
    assert ran.returncode == (0 if step == "release" else 3), ran.stdout + ran.stderr
    require_either(rover, driving, before, step)

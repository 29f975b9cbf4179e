"""Each step of a push, interrupted: the old release goes on, or the new one runs, and the next push goes through."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.system.deploy.motors import awaited
from tests.system.deploy.projects import carrying, needing
from tests.system.deploy.rover import Rover

RAD_S = 2.0
ENDING_S = 120
HEAVY_MB = 40
"""Takes a moment to send."""

SIGNS = {
    "sent": "incoming/*/project/.heavy.bin.*",
    "environment": "environments/*/bin/pip",
    "doctor": "incoming/*/environment",
    "release": "trial.json",
}
"""What is there while the robot is in a step, and was not before."""


@pytest.mark.parametrize("step", SIGNS)
def test_ctrl_c(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    ran = interrupted(rover, step, lambda push: os.killpg(push.pid, signal.SIGINT))
    assert ran.returncode == -signal.SIGINT, ran.stderr
    assert ("Nothing has changed" in ran.stderr) == (step != "release"), ran.stderr
    require_either(rover, driving, before, step)


@pytest.mark.parametrize("step", SIGNS)
def test_desk_is_killed(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    interrupted(rover, step, subprocess.Popen.kill)
    require_either(rover, driving, before, step)


@pytest.mark.parametrize("step", SIGNS)
def test_connection_is_killed(rover: Rover, driving: int, step: str) -> None:
    """While a release is on trial, the desk connects again and tells what came of it."""
    before = rover.release
    ran = interrupted(rover, step, lambda _: rover.machine.as_root("systemctl", "kill", "--signal=KILL", "session-*"))
    assert ran.returncode == (0 if step == "release" else 3), ran.stdout + ran.stderr
    require_either(rover, driving, before, step)


def test_disk_that_fills_up_while_files_are_sent(rover: Rover) -> None:
    with small_disk(rover, spare_mb=HEAVY_MB + 120) as fill:
        driving, before = rover.motors.await_driving(RAD_S), rover.release
        ran = interrupted(rover, "sent", lambda _: fill())
        assert (ran.returncode, "full" in ran.stderr or "No space" in ran.stderr) == (3, True), ran.stderr
        require_either(rover, driving, before, "sent")


def test_disk_that_is_too_small_for_what_pip_installs(rover: Rover) -> None:
    with small_disk(rover, spare_mb=150):
        driving, before = rover.motors.await_driving(RAD_S), rover.release
        ran = interrupted(rover, "environment", lambda _: None)
        assert (ran.returncode, "full" in ran.stderr or "No space" in ran.stderr) == (3, True), ran.stderr
        require_either(rover, driving, before, "environment")


def interrupted(
    rover: Rover, step: str, deed: Callable[[subprocess.Popen[str]], object]
) -> subprocess.CompletedProcess[str]:
    """Push what has to take this step, and do the deed in the middle of it; return what came of the push."""
    change = needing(rover.project) if step == "environment" else carrying(rover.project, HEAVY_MB)
    was_there = set(rover.files.glob(SIGNS[step]))

    def begun() -> int | None:
        return 1 if set(rover.files.glob(SIGNS[step])) - was_there else None

    with change, rover.pushing("--set", f"speed_rad_s={RAD_S:g}") as push:
        awaited(begun, f"the step {step!r}", lambda: (push.poll(), rover.releases))
        deed(push)
        out, err = push.communicate(timeout=ENDING_S)
        return subprocess.CompletedProcess(push.args, push.returncode, out, err)


def require_either(rover: Rover, driving: int, before: str, step: str) -> None:
    """The very process that drove drives on; or, once a release was on trial, a process of that one."""
    rover.await_judged()
    if step == "release":
        assert rover.release > before
        rover.motors.await_driving(RAD_S, instead_of=driving)
    else:
        assert (rover.release, rover.process) == (before, driving)
        assert rover.motors.await_driving(RAD_S) == driving


@contextmanager
def small_disk(rover: Rover, spare_mb: int) -> Iterator[Callable[[], object]]:
    """Let the robot's files be on a disk with little room left; gives what fills it up."""
    rover.done("stop")
    home = f"/home/{rover.machine.home.name}"
    rover.machine.as_root("sh", "-c", SMALL.format(home=home, spare_mb=spare_mb))
    try:
        rover.done("start")
        yield lambda: rover.machine.as_root("sh", "-c", f"cat /dev/zero > {home}/robotcore/full", is_checked=False)
    finally:
        rover.done("stop")
        rover.machine.as_root("umount", "--lazy", f"{home}/robotcore")


SMALL = """
set -e
size=$(( $(du -s -m {home}/robotcore | cut -f 1) + {spare_mb} ))
mkdir -p /run/small
mount -t tmpfs -o size=${{size}}m,mode=755 small /run/small
cp -a {home}/robotcore/. /run/small
chown --reference={home}/robotcore /run/small
mount --move /run/small {home}/robotcore
"""

"""The steps of a push, as they are seen on the robot from outside, and a deed in the middle of one."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.system.deploy.motors import awaited
from tests.system.deploy.rover import Ran, Rover, with_large_file, with_requirement
from tests.system.speed import scaled

RAD_S = 2.0
HEAVY_MB = 40
"""Takes a moment to send."""

ENDING_S = 120
"""Of what is left of a push, on the reference machine: a hang."""

SIGNS = {
    "sent": "incoming/*/project/.heavy.bin.*",
    "environment": "environments/*/bin/pip",
    "doctor": "incoming/*/environment",
}
"""What is there on the robot in a step, and was not before; in the last one, the new release is in place."""

STEPS = (*SIGNS, "release")


def push_interrupted(rover: Rover, step: str, deed: Callable[[subprocess.Popen[str]], object]) -> Ran:
    """Push what has to take this step, and do the deed in the middle of it; return what came of the push."""
    change = with_requirement(rover.project) if step == "environment" else with_large_file(rover.project, HEAVY_MB)
    before = _seen(rover, step)
    with change, rover.pushing("--set", f"speed_rad_s={RAD_S:g}") as push:
        awaited(lambda: 1 if _seen(rover, step) - before else None, f"the step {step!r}", push.poll)
        deed(push)
        out, err = push.communicate(timeout=scaled(ENDING_S))
        return Ran(push.args, push.returncode, out, err)


def require_either(rover: Rover, driving: int, before: str, step: str) -> None:
    """The very process that drove drives on; or, once a new release was in place, a process of that one."""
    rover.await_judged()
    if step == "release":
        assert rover.release > before
        rover.motors.await_driving(RAD_S, instead_of=driving)
    else:
        assert (rover.release, rover.process) == (before, driving)
        assert rover.motors.await_driving(RAD_S) == driving


def _seen(rover: Rover, step: str) -> set[str]:
    return {rover.release} if step == "release" else set(map(str, rover.files.glob(SIGNS[step])))


@pytest.mark.parametrize("step", STEPS)
def test_ctrl_c(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    ran = push_interrupted(rover, step, lambda push: os.killpg(push.pid, signal.SIGINT))
    assert ran.returncode == -signal.SIGINT, ran.stderr
    assert ("Nothing has changed" in ran.stderr) == (step != "release"), ran.stderr
    require_either(rover, driving, before, step)


@pytest.mark.parametrize("step", ["sent", "release"])
def test_desk_is_killed(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    push_interrupted(rover, step, subprocess.Popen.kill)
    require_either(rover, driving, before, step)


@pytest.mark.parametrize("step", ["sent", "release"])
def test_connection_is_killed(rover: Rover, driving: int, step: str) -> None:
    """While a release is on trial, the desk connects again and tells what came of it."""
    before = rover.release
    ran = push_interrupted(
        rover, step, lambda _: rover.machine.as_root("systemctl", "kill", "--signal=KILL", "session-*")
    )
    assert ran.returncode == (0 if step == "release" else 3), ran.stdout + ran.stderr
    require_either(rover, driving, before, step)


SMALL = """
set -e
size=$(( $(du -s -m {home}/robotcore | cut -f 1) + {spare_mb} ))
mkdir -p /run/small
mount -t tmpfs -o size=${{size}}m,mode=755 small /run/small
cp -a {home}/robotcore/. /run/small
chown --reference={home}/robotcore /run/small
mount --bind /run/small {home}/robotcore
"""


def test_disk_that_fills_up_while_files_are_sent(rover: Rover) -> None:
    with small_disk(rover, spare_mb=HEAVY_MB + 120) as fill:
        driving, before = rover.motors.await_driving(RAD_S), rover.release
        ran = push_interrupted(rover, "sent", lambda _: fill())
        assert (ran.returncode, "full" in ran.stderr) == (3, True), ran.stderr
        require_either(rover, driving, before, "sent")


@pytest.mark.parametrize("spare_mb", [60, 220], ids=["to send anything", "for what pip installs"])
def test_disk_that_is_too_small(rover: Rover, spare_mb: int) -> None:
    with small_disk(rover, spare_mb), with_requirement(rover.project):
        driving, before = rover.motors.await_driving(RAD_S), rover.release
        ran = rover.push()
        assert (ran.returncode, "full" in ran.stderr) == (3, True), ran.stderr
        require_either(rover, driving, before, "sent")


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
        rover.machine.as_root("umount", "--lazy", f"{home}/robotcore", "/run/small")

"""Interruptions in each step of a push, and full disks. Afterwards the old or the new release runs."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.system.deploy.motors import wait_for
from tests.system.deploy.rover import Ran, Rover, add_large_file, add_requirement
from tests.system.speed import scaled

RAD_S = 2.0
HEAVY_MB = 40
"""The size of a file that takes a moment to send."""

ENDING_S = 120
"""The time limit for the rest of a push on the reference machine, in s."""

SIGNS = {
    "sent": "incoming/*/project/.heavy.bin.*",
    "environment": "environments/*/bin/pip",
    "doctor": "incoming/*/environment",
}
"""The files on the robot that exist from each step on. The last step, ``release``, changes the current release."""

STEPS = (*SIGNS, "release")


def interrupt_push(rover: Rover, step: str, interrupt: Callable[[subprocess.Popen[str]], object]) -> Ran:
    """Push, and call ``interrupt`` with the process during this step; return the result of the push."""
    change = add_requirement(rover.project) if step == "environment" else add_large_file(rover.project, HEAVY_MB)
    before = _find_signs(rover, step)
    with change, rover.run_push("--set", f"speed_rad_s={RAD_S:g}") as push:
        wait_for(lambda: 1 if _find_signs(rover, step) - before else None, f"the step {step!r}", push.poll)
        interrupt(push)
        out, err = push.communicate(timeout=scaled(ENDING_S))
        return Ran(push.args, push.returncode, out, err)


def require_driving_app(rover: Rover, driving: int, before: str, step: str) -> None:
    """Require that the app of the new release drives after the step ``release``, and the old process after others."""
    rover.await_health_check()
    if step == "release":
        assert rover.release > before
        rover.motors.await_driving(RAD_S, instead_of=driving)
    else:
        assert (rover.release, rover.process) == (before, driving)
        assert rover.motors.await_driving(RAD_S) == driving


def _find_signs(rover: Rover, step: str) -> set[str]:
    return {rover.release} if step == "release" else set(map(str, rover.files.glob(SIGNS[step])))


@pytest.mark.parametrize("step", STEPS)
def test_ctrl_c_keeps_a_release_running(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    done = interrupt_push(rover, step, lambda push: os.killpg(push.pid, signal.SIGINT))
    assert done.returncode == -signal.SIGINT, done.stderr
    assert ("Nothing has changed" in done.stderr) == (step != "release"), done.stderr
    require_driving_app(rover, driving, before, step)


@pytest.mark.parametrize("step", ["sent", "release"])
def test_killed_client_keeps_a_release_running(rover: Rover, driving: int, step: str) -> None:
    before = rover.release
    interrupt_push(rover, step, subprocess.Popen.kill)
    require_driving_app(rover, driving, before, step)


@pytest.mark.parametrize("step", ["sent", "release"])
def test_killed_connection_keeps_a_release_running(rover: Rover, driving: int, step: str) -> None:
    """During a health check, the client connects again and reports the result."""
    before = rover.release
    done = interrupt_push(
        rover, step, lambda _: rover.machine.as_root("systemctl", "kill", "--signal=KILL", "session-*")
    )
    assert done.returncode == (0 if step == "release" else 3), done.stdout + done.stderr
    require_driving_app(rover, driving, before, step)


SMALL = """
set -e
size=$(( $(du -s -m {home}/robotcore | cut -f 1) + {spare_mb} ))
mkdir -p /run/small
mount -t tmpfs -o size=${{size}}m,mode=755 small /run/small
cp -a {home}/robotcore/. /run/small
chown --reference={home}/robotcore /run/small
mount --bind /run/small {home}/robotcore
"""


def test_disk_that_fills_during_the_upload_keeps_the_release_running(rover: Rover) -> None:
    with small_disk(rover, spare_mb=HEAVY_MB + 120) as fill:
        driving, before = rover.motors.await_driving(RAD_S), rover.release
        done = interrupt_push(rover, "sent", lambda _: fill())
        assert (done.returncode, "full" in done.stderr) == (3, True), done.stderr
        require_driving_app(rover, driving, before, "sent")


@pytest.mark.parametrize("spare_mb", [60, 220], ids=["to send anything", "for what pip installs"])
def test_too_small_disk_keeps_the_release_running(rover: Rover, spare_mb: int) -> None:
    with small_disk(rover, spare_mb), add_requirement(rover.project):
        driving, before = rover.motors.await_driving(RAD_S), rover.release
        done = rover.push()
        assert (done.returncode, "full" in done.stderr) == (3, True), done.stderr
        require_driving_app(rover, driving, before, "sent")


@contextmanager
def small_disk(rover: Rover, spare_mb: int) -> Iterator[Callable[[], object]]:
    """Move robotcore's files to a disk with little free space; yield a function that fills it."""
    rover.run("stop")
    home = f"/home/{rover.machine.home.name}"
    rover.machine.as_root("sh", "-c", SMALL.format(home=home, spare_mb=spare_mb))
    try:
        rover.run("start")
        yield lambda: rover.machine.as_root("sh", "-c", f"cat /dev/zero > {home}/robotcore/full", is_checked=False)
    finally:
        rover.run("stop")
        rover.machine.as_root("umount", "--lazy", f"{home}/robotcore", "/run/small")

"""A disk that is full on the robot: what runs goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.system.deploy.projects import needing
from tests.system.deploy.rover import Rover
from tests.system.deploy.steps import HEAVY_MB, RAD_S, interrupted, require_either

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
        ran = interrupted(rover, "sent", lambda _: fill())
        assert (ran.returncode, "full" in ran.stderr) == (3, True), ran.stderr
        require_either(rover, driving, before, "sent")


@pytest.mark.parametrize("spare_mb", [60, 220], ids=["to send anything", "for what pip installs"])
def test_disk_that_is_too_small(rover: Rover, spare_mb: int) -> None:
    with small_disk(rover, spare_mb), needing(rover.project):
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

"""What a robot may lack: each is refused with what to do about it, and what runs goes on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tests.system.deploy.projects import needing
from tests.system.deploy.rover import Rover

LINGER = "var/lib/systemd/linger/pi"
RSYNC = "usr/bin/rsync"
VENV = "usr/lib/python3.11/ensurepip"
OFFLINE = "--offline"


def test_robot_whose_user_does_not_linger(rover: Rover, driving: int) -> None:
    with lacking(rover, LINGER):
        require_refused(rover, driving, "sudo loginctl enable-linger pi", OFFLINE)


def test_robot_without_rsync(rover: Rover, driving: int) -> None:
    with lacking(rover, RSYNC):
        require_refused(rover, driving, "sudo apt install rsync", OFFLINE)


def test_robot_without_venv(rover: Rover, driving: int) -> None:
    with lacking(rover, VENV), needing(rover.project):
        require_refused(rover, driving, "sudo apt install python3-venv", OFFLINE)


def test_robot_without_network(rover: Rover, driving: int) -> None:
    with needing(rover.project):
        require_refused(rover, driving, OFFLINE)


@contextmanager
def lacking(rover: Rover, path: str) -> Iterator[None]:
    """Take something away from the robot."""
    there = rover.machine.root / path
    away = there.with_name(f"{there.name}-away")
    there.rename(away)
    try:
        yield
    finally:
        away.rename(there)


def require_refused(rover: Rover, driving: int, remedy: str, *arguments: str) -> None:
    """Push; what runs must not be touched, and what to do has to be said in few words."""
    releases = set(rover.releases)
    ran = rover.deploy("push", "--skip-checks", *arguments)
    assert (ran.returncode, remedy in ran.stderr) == (3, True), ran.stdout + ran.stderr
    assert len(ran.stderr.strip().splitlines()) <= 2, ran.stderr
    assert (rover.process, set(rover.releases) - releases) == (driving, set())

"""What a robot may lack: each is refused with what to do about it, and what runs goes on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tests.system.deploy.projects import needing
from tests.system.deploy.rover import Rover

LINGER = "var/lib/systemd/linger/pi"
RSYNC = "usr/bin/rsync"
VENV = "usr/lib/python3.11/ensurepip"


def test_robot_whose_user_does_not_linger(rover: Rover) -> None:
    with lacking(rover, LINGER):
        require_refused(rover, "sudo loginctl enable-linger pi")


def test_robot_without_rsync(rover: Rover) -> None:
    with lacking(rover, RSYNC):
        require_refused(rover, "sudo apt install rsync")


def test_robot_without_venv(rover: Rover) -> None:
    with lacking(rover, VENV), needing(rover.project):
        require_refused(rover, "sudo apt install python3-venv")


def test_robot_without_network(rover: Rover) -> None:
    with needing(rover.project):
        require_refused(rover, "--offline", arguments=("--skip-checks",))


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


def require_refused(rover: Rover, remedy: str, arguments: tuple[str, ...] = ("--skip-checks", "--offline")) -> None:
    """Push; what runs must not be touched, and what to do has to be said in few words."""
    rover.done("start")
    driving, releases = rover.motors.await_driving(), rover.releases
    ran = rover.deploy("push", *arguments)
    assert (ran.returncode, remedy in ran.stderr) == (3, True), ran.stdout + ran.stderr
    assert len(ran.stderr.strip().splitlines()) <= 2, ran.stderr
    assert (rover.process, rover.releases) == (driving, releases)

"""The target is what a robot on a desk is: an ordinary user by ssh, whose services run without a login."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.system.deploy.desk import Desk
from tests.system.deploy.machine import Machine
from tests.system.deploy.rover import Rover, with_requirement


def test_user_is_let_in_by_key_and_has_a_service_manager(desk: Desk) -> None:
    assert desk.ssh("systemctl --user is-system-running --wait; id --user --name") == "running\npi\n"


def test_nobody_else_is_reached_from_there(target: Machine) -> None:
    assert "default" not in target.as_root("cat", "/proc/net/route")
    with pytest.raises(subprocess.CalledProcessError):
        target.as_root("getent", "hosts", "example.org")


def test_it_comes_back_with_the_user_s_services_and_all_files(desk: Desk, target: Machine) -> None:
    desk.ssh("touch kept")
    for go_down in (target.shut_down, target.cut_power):
        go_down()
        target.boot()
        assert desk.ssh("systemctl --user is-system-running --wait; ls kept") == "running\nkept\n"


LINGER = "var/lib/systemd/linger/pi"
RSYNC = "usr/bin/rsync"
VENV = "usr/lib/python3.11/ensurepip"
OFFLINE = "--offline"


def test_robot_whose_user_does_not_linger(rover: Rover, driving: int) -> None:
    with without_file(rover, LINGER):
        require_refused(rover, driving, "sudo loginctl enable-linger pi", OFFLINE)


def test_robot_without_rsync(rover: Rover, driving: int) -> None:
    with without_file(rover, RSYNC):
        require_refused(rover, driving, "sudo apt install rsync", OFFLINE)


def test_robot_without_venv(rover: Rover, driving: int) -> None:
    with without_file(rover, VENV), with_requirement(rover.project):
        require_refused(rover, driving, "sudo apt install python3-venv", OFFLINE)


def test_robot_without_network(rover: Rover, driving: int) -> None:
    with with_requirement(rover.project):
        require_refused(rover, driving, OFFLINE)


@contextmanager
def without_file(rover: Rover, path: str) -> Iterator[None]:
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

"""The robot of the checks, and a robot that lacks a need of a push: it is refused with a remedy."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.system.deploy.client import Client
from tests.system.deploy.machine import Machine
from tests.system.deploy.rover import Rover, add_requirement


def test_user_can_log_in_by_key_and_has_a_service_manager(client: Client) -> None:
    assert client.ssh("systemctl --user is-system-running --wait; id --user --name") == "running\npi\n"


def test_robot_reaches_only_the_client(target: Machine) -> None:
    assert "default" not in target.as_root("cat", "/proc/net/route")
    with pytest.raises(subprocess.CalledProcessError):
        target.as_root("getent", "hosts", "example.org")


def test_reboot_restores_services_and_files(client: Client, target: Machine) -> None:
    client.ssh("touch kept")
    for go_down in (target.shut_down, target.cut_power):
        go_down()
        target.boot()
        assert client.ssh("systemctl --user is-system-running --wait; ls kept") == "running\nkept\n"


LINGER = "var/lib/systemd/linger/pi"
RSYNC = "usr/bin/rsync"
VENV = "usr/lib/python3.11/ensurepip"
OFFLINE = "--offline"


def test_robot_without_lingering_is_refused(rover: Rover, driving: int) -> None:
    with remove_file(rover, LINGER):
        require_refused(rover, driving, "sudo loginctl enable-linger pi", OFFLINE)


def test_robot_without_rsync_is_refused(rover: Rover, driving: int) -> None:
    with remove_file(rover, RSYNC):
        require_refused(rover, driving, "sudo apt install rsync", OFFLINE)


def test_robot_without_venv_is_refused(rover: Rover, driving: int) -> None:
    with remove_file(rover, VENV), add_requirement(rover.project):
        require_refused(rover, driving, "sudo apt install python3-venv", OFFLINE)


def test_robot_without_a_network_is_refused(rover: Rover, driving: int) -> None:
    with add_requirement(rover.project):
        require_refused(rover, driving, OFFLINE)


@contextmanager
def remove_file(rover: Rover, path: str) -> Iterator[None]:
    """Remove a file from the robot during the block."""
    there = rover.machine.root / path
    away = there.with_name(f"{there.name}-away")
    there.rename(away)
    try:
        yield
    finally:
        away.rename(there)


def require_refused(rover: Rover, driving: int, remedy: str, *arguments: str) -> None:
    """Push, and require a short error message with the remedy, and an unchanged running app."""
    releases = set(rover.releases)
    done = rover.deploy("push", "--skip-checks", *arguments)
    assert (done.returncode, remedy in done.stderr) == (3, True), done.stdout + done.stderr
    assert len(done.stderr.strip().splitlines()) <= 2, done.stderr
    assert (rover.process, set(rover.releases) - releases) == (driving, set())

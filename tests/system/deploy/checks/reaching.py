"""The target is what a robot on a desk is: an ordinary user by ssh, whose services run without a login."""

from __future__ import annotations

import subprocess

import pytest

from tests.system.deploy.desk import Desk
from tests.system.deploy.machine import Machine


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

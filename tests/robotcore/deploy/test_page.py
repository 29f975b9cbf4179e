"""The live page of a robot through a real sshd."""

from __future__ import annotations

import os
import signal
import socket
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from robotcore.deploy.page import forward_page
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError, EmergencyStopError
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd, serving
from tests.robotcore.live.conftest import browser, start_run
from tests.robotcore.live.live_run import StartRun
from tests.texts import Raises

__all__ = ["browser", "start_run"]

NAME = "2026-11-21T22-52-10Z"

STATUS: dict[str, Any] = {
    "release": NAME,
    "outcome": "healthy",
    "pending": None,
    "last": None,
    "state": "running",
    "for_s": 3.0,
    "restarts": 0,
    "status_text": "",
    "view_port": None,
    "reason": "",
    "lines": [],
    "starts_with_robot": True,
    "lingers": True,
    "recordings": {"files": 0, "bytes": 0},
    "free_bytes": 1,
}


def answer(add_action: AddAction, **change: object) -> None:
    """Let the robot answer ``status``."""
    add_action("status", f"def act(layout):\n    return { ({**STATUS, **change})!r}\n")


def find_free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


@pytest.mark.slow
def test_the_page_of_the_robot_shows_the_run_and_stops_it(
    link: RobotLink, add_action: AddAction, start_run: StartRun, browser: Browser
) -> None:
    run = start_run()
    answer(add_action, view_port=int(run.view.link.rstrip("/").rpartition(":")[2]))
    forwarded = forward_page(link)
    assert forwarded != run.view.link
    page = browser.new_page()
    page.goto(forwarded)
    expect(page.locator("#state")).to_have_text("turning")
    page.keyboard.press("Space")
    assert isinstance(run.wait().error, EmergencyStopError)
    page.close()


@pytest.mark.parametrize(
    "change, kind",
    [
        ({"release": None, "state": "stopped"}, "no-running-app"),
        ({"state": "ended", "view_port": 8080}, "no-running-app"),
        ({}, "no-page"),
    ],
    ids=["empty", "ended", "without a page"],
)
def test_a_robot_without_a_page_is_an_error_that_names_the_command(
    link: RobotLink, robot: Sshd, add_action: AddAction, raises: Raises, change: dict[str, Any], kind: str
) -> None:
    answer(add_action, **change)
    with raises(DeployError, kind, hide=[robot.config]):
        forward_page(link)


def test_a_page_that_does_not_answer_is_an_error(
    link: RobotLink, robot: Sshd, add_action: AddAction, raises: Raises
) -> None:
    answer(add_action, view_port=(port := find_free_port()))
    with raises(DeployError, "silent-page", hide=[robot.config, str(port)]):
        forward_page(link)


@pytest.mark.slow
def test_a_robot_that_forbids_forwarding_is_an_error(
    add_action: AddAction, start_run: StartRun, tmp_path: Path
) -> None:
    run = start_run()
    answer(add_action, view_port=int(run.view.link.rstrip("/").rpartition(":")[2]))
    with (
        serving(tmp_path / "strict", "AllowTcpForwarding no") as strict,
        RobotLink(strict.address) as link,
        pytest.raises(DeployError) as raised,
    ):
        forward_page(link)
    assert raised.value.kind == "silent-page"


def test_a_port_of_a_robot_is_validated(link: RobotLink, add_action: AddAction) -> None:
    answer(add_action, view_port=70_000)
    with pytest.raises(DeployError) as raised:
        forward_page(link)
    assert raised.value.kind == "damaged"


def test_waiting_ends_if_the_connection_breaks(sshd: Sshd) -> None:
    with RobotLink(sshd.address) as link:
        for pid in sshd.connections():
            os.kill(pid, signal.SIGKILL)
        with pytest.raises(DeployError) as raised:
            link.wait()
    assert raised.value.kind == "broken"


def test_the_forwarding_ends_with_the_connection(sshd: Sshd) -> None:
    with RobotLink(sshd.address) as link:
        port = link.forward(find_free_port())
        socket.create_connection(("127.0.0.1", port)).close()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", port))

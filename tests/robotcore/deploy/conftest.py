"""Fixtures: a robot behind a real sshd, and actions that are added to its agent."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator

import pytest

from robotcore.deploy import rpc
from robotcore.deploy.rpc import RobotLink
from tests.robotcore.deploy.sshd import Sshd, robot, sshd

__all__ = ["add_action", "robot", "sshd"]


@pytest.fixture(scope="session")
def shared_link(robot: Sshd) -> Iterator[RobotLink]:
    with RobotLink(robot.address) as link:
        yield link


@pytest.fixture
def link(robot: Sshd, shared_link: RobotLink) -> RobotLink:
    """The link that all tests share. It must still work after each test."""
    shutil.rmtree(robot.home / "robotcore", ignore_errors=True)
    (robot.home / "robotcore" / "incoming" / "new").mkdir(parents=True)
    (robot.home / "robotcore" / "recordings").mkdir()
    return shared_link


AddAction = Callable[[str, str], None]

ECHO = """
def act(layout, **arguments):
    return {"arguments": arguments}
"""

WAIT = """
import os, subprocess
from robotcore.deploy.agent.rpc import report_progress

def act(layout):
    child = subprocess.Popen(["sleep", "600"])
    report_progress(f"{os.getpid()} {child.pid}")
    child.wait()
    return {}
"""


@pytest.fixture
def add_action(monkeypatch: pytest.MonkeyPatch) -> AddAction:
    """Adds an action to the agent: its name and its source."""
    added = rpc.read_agent_sources()

    def put(name: str, source: str) -> None:
        added[f"robotcore/deploy/agent/{name}_for_test.py"] = source
        added["robotcore/deploy/agent/rpc.py"] += f"\nACTIONS[{name!r}] = '{name}_for_test:act'\n"

    monkeypatch.setattr(rpc, "read_agent_sources", lambda: added)
    return put

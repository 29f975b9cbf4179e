"""One robot for the tests of a module, and one link to it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest

from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.link import Link
from tests.robotcore.deploy.sshd import Sshd, serving


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sshd]:
    with serving(tmp_path_factory.mktemp("robot") / "sshd") as server:
        yield server


@pytest.fixture(scope="module")
def held(robot: Sshd) -> Iterator[Link]:
    with Link(Host.parse(robot.host), robot.config) as link:
        yield link


@pytest.fixture
def link(robot: Sshd, held: Link) -> Link:
    """One link for all: whatever a test does with it leaves it working."""
    shutil.rmtree(robot.home / "robotcore", ignore_errors=True)
    (robot.home / "robotcore" / "incoming" / "new").mkdir(parents=True)
    (robot.home / "robotcore" / "recordings").mkdir()
    return held

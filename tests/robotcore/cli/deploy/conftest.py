from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from tests.robotcore.cli.conftest import Answer, Cli
from tests.robotcore.deploy.conftest import add_action
from tests.robotcore.deploy.sshd import Sshd, serving

__all__ = ["add_action"]

Deploy = Callable[..., Answer]


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sshd]:
    """A real sshd on loopback."""
    with serving(tmp_path_factory.mktemp("robot") / "sshd") as server:
        yield server


@pytest.fixture
def deploy(cli: Cli, robot: Sshd) -> Deploy:
    """Runs a command of ``robotcore deploy`` against the robot."""

    def run(command: str, *arguments: str) -> Answer:
        return cli("deploy", command, robot.host, "--ssh-config", str(robot.config), *arguments)

    return run

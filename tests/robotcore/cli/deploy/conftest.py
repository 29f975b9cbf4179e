from __future__ import annotations

import shutil
from collections.abc import Callable

import pytest

from tests.robotcore.cli.conftest import Answer, Cli
from tests.robotcore.deploy.conftest import add_action
from tests.robotcore.deploy.sshd import Sshd, robot

__all__ = ["add_action", "robot"]

Deploy = Callable[..., Answer]


@pytest.fixture
def deploy(cli: Cli, robot: Sshd) -> Deploy:
    """Runs a command of ``robotcore deploy`` against the robot, which has no release."""
    shutil.rmtree(robot.home / "robotcore", ignore_errors=True)

    def run(command: str, *arguments: str) -> Answer:
        return cli("deploy", command, "robot", "--ssh-config", str(robot.config), *arguments)

    return run

"""Fixtures of the checks: one robot that stays on from the first check to the last, and the client."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.system.deploy.client import Client
from tests.system.deploy.machine import Machine, make_machine
from tests.system.deploy.rover import BENCH, Rover


@pytest.fixture(autouse=True)
def _nothing_is_left_running() -> None:
    """Replace the fixture that ends processes, because a robot that a check has booted again must stay on."""


@pytest.fixture(scope="session")
def target() -> Iterator[Machine]:
    """A robot that is switched on."""
    with make_machine() as machine:
        machine.boot()
        yield machine


@pytest.fixture(scope="session")
def client(target: Machine, tmp_path_factory: pytest.TempPathFactory) -> Client:
    return Client.of(tmp_path_factory.mktemp("client"), target)


@pytest.fixture(scope="session")
def rover(target: Machine, client: Client, tmp_path_factory: pytest.TempPathFactory) -> Rover:
    """A robot on which the project of the bench drives."""
    project = Path(shutil.copytree(BENCH, tmp_path_factory.mktemp("client") / "bench"))
    client.install(project)
    deployed = Rover(target, client, project)
    deployed.drive(2.0)
    return deployed


@pytest.fixture
def driving(rover: Rover) -> int:
    """The process of the app, which drives."""
    rover.run("start")
    return rover.motors.await_driving()

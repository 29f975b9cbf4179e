"""``robotcore check --backend``: what of a robot is there in a scene."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from robotcore.errors import BackendError
from robotcore.hal.backend import Setup
from robotcore.hal.finding import Finding
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.simulation.remote_scene.memory import MemoryBackend

JOINT = Finding.ok("left_motor", "/rover/leftMotor, a joint")
LOST = Finding.error("nose", "the scene has no object '/nose'", "Did you mean '/rover/nose'?")


class Looking(MemoryBackend):
    found = (JOINT,)
    asked: Setup

    def inspect_scene(self, setup: Setup) -> Iterator[Finding]:
        Looking.asked = setup
        yield from self.found


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.hal.backend.load_backend", lambda _name: Looking())


def test_what_is_there_is_reported_device_by_device(cli: Cli) -> None:
    answer = cli("check", "rover", "--backend", "memory", "--port", "19997", "--option", "stepped=false")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out.splitlines()[1].split() == ["ok", "left_motor", "/rover/leftMotor,", "a", "joint"]
    assert Looking.asked.robot.name == "rover"
    assert Looking.asked.options == {"port": "19997", "stepped": "false"}


def test_what_is_missing_fails_and_is_reported_with_what_to_do(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Looking, "found", (LOST, JOINT))
    answer = cli("check", "rover", "--backend", "memory")
    assert answer.status == 1
    assert "the scene has no object '/nose'" in answer.out
    assert "→ Did you mean '/rover/nose'?" in answer.out


def test_simulator_that_does_not_answer_is_the_backends_failure(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def dead(*_: object) -> Iterator[Finding]:
        raise BackendError("nobody answers at 127.0.0.1:19997")

    monkeypatch.setattr(Looking, "inspect_scene", dead)
    answer = cli("check", "rover", "--backend", "memory")
    assert (answer.status, answer.err) == (3, "error: nobody answers at 127.0.0.1:19997\n")


def test_backend_that_joins_no_scene_has_nothing_to_look_at(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(Looking, "inspect_scene")
    answer = cli("check", "rover", "--backend", "memory")
    assert answer.status == 2
    assert "nothing to look at" in answer.err


@pytest.mark.parametrize("asked", [("arena", "--backend", "memory"), ("rover", "--port", "19997")])
def test_what_means_nothing_together_is_refused(cli: Cli, asked: tuple[str, ...]) -> None:
    assert cli("check", *asked).status == 2

"""``robotcore check --backend`` looks for the devices of a robot in a scene."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from robotcore.hal.backend import Setup
from robotcore.hal.check_finding import Finding
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.simulation.remote_scene.memory import MemoryBackend
from tests.texts import CheckText

JOINT = Finding.ok("left_motor", "/rover/leftMotor, a joint", kind="object-found")
LOST = Finding.error("nose", "the scene has no object '/nose'", "Did you mean '/rover/nose'?", kind="object-missing")


class SceneBackend(MemoryBackend):
    findings = (JOINT,)
    setups: list[Setup] = []  # noqa: RUF012

    def inspect_scene(self, setup: Setup) -> Iterator[Finding]:
        self.setups.append(setup)
        yield from self.findings


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.hal.backend.load_backend", lambda _name: SceneBackend())


def test_devices_in_the_scene_are_listed(cli: Cli, check_text: CheckText) -> None:
    answer = cli("check", "rover", "--backend", "memory", "--port", "19997", "--option", "stepped=false")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)
    assert SceneBackend.setups[-1].robot.name == "rover"
    assert SceneBackend.setups[-1].options == {"port": "19997", "stepped": "false"}


def test_a_missing_device_has_exit_status_1_and_a_remedy(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr(SceneBackend, "findings", (LOST, JOINT))
    answer = cli("check", "rover", "--backend", "memory")
    assert answer.status == 1
    check_text(answer.out)


def test_backend_without_a_scene_is_refused(cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    monkeypatch.delattr(SceneBackend, "inspect_scene")
    answer = cli("check", "rover", "--backend", "memory")
    assert answer.status == 2
    check_text(answer.err)


@pytest.mark.parametrize("arguments", [("arena", "--backend", "memory"), ("rover", "--port", "19997")])
def test_conflicting_options_are_refused(cli: Cli, arguments: tuple[str, ...]) -> None:
    assert cli("check", *arguments).status == 2

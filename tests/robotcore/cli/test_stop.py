from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from robotcore.hal.backend import Setup
from robotcore.hal.cutoff import CutoffSpec
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.safety.guardian.doubles import RecordingBackend, cutoff
from tests.robotcore.safety.guardian.recorder import notes
from tests.texts import CheckText


class CutoffBackend(RecordingBackend):
    """A backend whose cutoffs log their calls. The cutoff of the device ``failing`` fails in the way ``manner``."""

    def __init__(self, diary: Path, failing: str = "", manner: str = "fails to stop") -> None:
        super().__init__(diary, manner)
        self._failing = failing
        self.asked: list[Setup] = []

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        self.asked.append(setup)
        manners = {name: self._manner if name == self._failing else "good" for name in sorted(setup.devices)}
        return [cutoff(self._file, name, manner) for name, manner in manners.items()]


@pytest.fixture
def diary(tmp_path: Path) -> Path:
    return tmp_path / "diary"


def install(monkeypatch: pytest.MonkeyPatch, backend: CutoffBackend) -> CutoffBackend:
    monkeypatch.setattr("robotcore.hal.backend.load_backend", lambda _: backend)
    return backend


def test_every_motor_is_stopped_and_no_other_device_is_opened(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    backend = install(monkeypatch, CutoffBackend(diary))
    answer = cli("stop", "--backend", "recording", "--option", "port=7")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)
    assert {"stop left_motor", "stop right_motor"} <= {note.action for note in notes(diary)}
    (setup,) = backend.asked
    assert (sorted(setup.devices), dict(setup.options)) == (["left_motor", "right_motor"], {"port": "7"})


def test_a_motor_that_cannot_be_stopped_is_named_and_the_others_are_stopped(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    install(monkeypatch, CutoffBackend(diary, failing="left_motor"))
    answer = cli("stop", "--backend", "recording")
    assert answer.status == 3
    check_text(answer.out)
    check_text(answer.err)


def test_an_unconfirmed_stop_is_not_reported_as_done(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    install(monkeypatch, CutoffBackend(diary, failing="left_motor", manner="is unsure"))
    answer = cli("stop", "--backend", "recording")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)


@pytest.mark.parametrize("backend", ["kinematic", "virtualpi", "mock"])
def test_a_simulator_has_nothing_to_stop(cli: Cli, backend: str, check_text: CheckText) -> None:
    answer = cli("stop", "--backend", backend)
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("--backend", "raspberypi"),
        ("--backend", "raspberrypi", "--robot", "gone.toml"),
        ("--backend", "raspberrypi", "--option", "port=7"),
    ],
)
def test_wrong_arguments_are_refused(cli: Cli, arguments: tuple[str, ...], check_text: CheckText) -> None:
    answer = cli("stop", *arguments)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)

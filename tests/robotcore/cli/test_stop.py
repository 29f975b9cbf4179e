from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from robotcore.hal.backend import Setup
from robotcore.hal.cutoff import CutoffSpec
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.safety.guardian.doubles import RecordingBackend, cutoff
from tests.robotcore.safety.guardian.recorder import notes


class Unopened(RecordingBackend):
    """Gives cutoffs that note what they are asked for; one of them may fail."""

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


def given(monkeypatch: pytest.MonkeyPatch, backend: Unopened) -> Unopened:
    monkeypatch.setattr("robotcore.hal.backend.load_backend", lambda _: backend)
    return backend


def test_every_motor_is_stopped_and_nothing_else_is_asked_for(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend = given(monkeypatch, Unopened(diary))
    answer = cli("stop", "--backend", "recording", "--option", "port=7")
    assert answer == (0, "rover: stopped left_motor, right_motor\n", "")
    assert {"stop left_motor", "stop right_motor"} <= {note.what for note in notes(diary)}
    (setup,) = backend.asked
    assert (sorted(setup.devices), dict(setup.options)) == (["left_motor", "right_motor"], {"port": "7"})


def test_a_motor_that_cannot_be_stopped_is_named_and_the_others_are_stopped(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given(monkeypatch, Unopened(diary, failing="left_motor"))
    answer = cli("stop", "--backend", "recording")
    assert (answer.status, answer.out) == (3, "rover: stopped right_motor\n")
    assert answer.err == "error: CANNOT STOP left_motor: OSError: no stop. Cut the motors' supply\n"


def test_a_motor_of_which_nobody_can_tell_is_not_said_to_be_stopped(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given(monkeypatch, Unopened(diary, failing="left_motor", manner="is unsure"))
    answer = cli("stop", "--backend", "recording")
    assert answer == (0, "rover: stopped right_motor\nrover: left_motor: nobody can tell\n", "")


@pytest.mark.parametrize("backend", ["kinematic", "virtualpi", "mock"])
def test_where_motors_turn_no_longer_than_their_run_there_is_nothing_to_stop(cli: Cli, backend: str) -> None:
    assert cli("stop", "--backend", backend) == (0, f"rover: nothing to stop on {backend}\n", "")


@pytest.mark.parametrize(
    "arguments, fault",
    [
        ((), "Missing option '--backend'"),
        (("--backend", "raspberypi"), "Did you mean 'raspberrypi'?"),
        (("--backend", "raspberrypi", "--robot", "gone.toml"), "gone.toml"),
        (("--backend", "raspberrypi", "--option", "port=7"), "unknown option 'port'"),
    ],
)
def test_what_is_asked_for_wrongly_is_refused(cli: Cli, arguments: tuple[str, ...], fault: str) -> None:
    answer = cli("stop", *arguments)
    assert (answer.status, answer.out) == (2, "")
    assert fault in answer.err

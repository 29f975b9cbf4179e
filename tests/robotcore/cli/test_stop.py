from __future__ import annotations

import os
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import pytest

from robotcore.hal.backend import Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.runtime.active_runs import ActiveRun
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.safety.guardian.conftest import start as start  # noqa: PLC0414  a fixture
from tests.robotcore.safety.guardian.doubles import RecordingBackend, Start, cutoff
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


@pytest.fixture(autouse=True)
def _runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Set folders in which no other program registers runs, so that no test ends a run of another program."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, which is empty."""
    (folder := tmp_path / "project").mkdir()
    monkeypatch.chdir(folder)
    return folder


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


@pytest.mark.slow
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


def test_a_simulator_has_nothing_to_stop(cli: Cli, check_text: CheckText) -> None:
    answer = cli("stop", "--backend", "virtualpi")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("--port", "/dev/ttyACM0"),
        ("--backend", "raspberypi"),
        ("--backend", "serial", "--option", "speed=7"),
    ],
)
@pytest.mark.linux("a stop finds runs in /proc")
def test_wrong_arguments_are_refused(
    cli: Cli, project: Path, arguments: tuple[str, ...], check_text: CheckText
) -> None:
    (project / "pyproject.toml").write_text('[tool.robotcore]\napp = "green-search"\n')
    answer = cli("stop", *arguments)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


@pytest.mark.slow
@pytest.mark.linux("a stop finds runs in /proc")
def test_without_a_backend_the_active_run_is_ended_and_its_robot_is_stopped(
    cli: Cli, diary: Path, start: Start, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    running = start("drives")
    backend = install(monkeypatch, CutoffBackend(diary))
    answer = cli("stop")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out, hide=[running.process.pid])
    assert running.read_result()["reason"] == "interrupted by SIGTERM"
    assert {"stop left_motor", "stop right_motor"} <= {note.action for note in notes(diary)}
    assert [sorted(setup.devices) for setup in backend.asked] == [["left_motor", "right_motor"]]


def install_runs(monkeypatch: pytest.MonkeyPatch, *robots: str) -> None:
    """Simulate active runs of these robots that must be killed."""
    runs = [ActiveRun(os.getpid(), "recording", robot, {}, Path(robot)) for robot in robots]
    monkeypatch.setattr("robotcore.runtime.active_runs.list_active_runs", lambda: runs)
    monkeypatch.setattr("robotcore.runtime.active_runs.end_runs", lambda runs, _: runs)


@pytest.mark.linux("a stop finds runs in /proc")
def test_the_robot_of_a_run_that_does_not_end_is_stopped_too(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    install(monkeypatch, CutoffBackend(diary))
    install_runs(monkeypatch, "rover")
    answer = cli("stop")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out, hide=[os.getpid()])


@pytest.mark.slow
@pytest.mark.linux("a stop finds runs in /proc")
def test_a_robot_that_cannot_be_stopped_does_not_prevent_the_stop_of_another(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend = install(monkeypatch, CutoffBackend(diary, failing="right_motor"))
    install_runs(monkeypatch, "gone", "rover", "lost")
    answer = cli("stop")
    assert answer.status == 3
    assert all(name in answer.err for name in ("gone", "right_motor", "lost"))
    assert [setup.robot.name for setup in backend.asked] == ["rover"]


@pytest.mark.linux("a stop finds runs in /proc")
def test_output_that_cannot_be_written_does_not_prevent_the_stop_of_another_robot(
    cli: Cli, diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(text: str) -> None:
        raise OSError(28, "No space left on device")

    backend = install(monkeypatch, CutoffBackend(diary))
    install_runs(monkeypatch, "rover", "rover")
    monkeypatch.setattr("robotcore.cli.stop.write_line", refuse)
    assert cli("stop").status != 0
    assert len(backend.asked) == 2


@pytest.mark.parametrize("robot", ["rover", "mine.toml"])
@pytest.mark.linux("a stop finds runs in /proc")
def test_without_a_run_the_robot_of_the_project_in_this_folder_is_stopped(
    cli: Cli, diary: Path, project: Path, monkeypatch: pytest.MonkeyPatch, robot: str, check_text: CheckText
) -> None:
    rover = files("robotcore.description.robots").joinpath("rover.toml").read_text()
    (project / "mine.toml").write_text(rover.replace('name = "rover"', 'name = "mine"'))
    table = f'[tool.robotcore]\nrobot = "{robot}"\n[tool.robotcore.deploy]\noptions = {{ port = 7 }}\n'
    (project / "pyproject.toml").write_text(table)
    backend = install(monkeypatch, CutoffBackend(diary))
    answer = cli("stop")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)
    (setup,) = backend.asked
    assert (setup.robot.name, dict(setup.options)) == (robot.removesuffix(".toml"), {"port": "7"})


@pytest.mark.linux("a stop finds runs in /proc")
def test_robot_of_the_project_on_a_machine_without_its_libraries_is_another_machine(
    cli: Cli, diary: Path, project: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    (project / "pyproject.toml").write_text('[tool.robotcore]\nrobot = "rover"\n')
    backend = install(monkeypatch, CutoffBackend(diary))
    monkeypatch.setattr(backend, "cutoffs", lambda _: [CutoffSpec("left_motor", "no_such_library:Cutoff")])
    answer = cli("stop")
    assert (answer.status, answer.out) == (3, "")
    check_text(answer.err)

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.errors import BackendError
from tests.robotcore.cli.conftest import Answer, Cli
from tests.robotcore.sweep.conftest import SWEEP_ID
from tests.texts import CheckText

BOTH = pytest.mark.parametrize("command", ["run", "sweep"])


@pytest.fixture(autouse=True)
def _enter_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def _answer(answer: Answer) -> tuple[str, str, int]:
    assert answer.json["exit_status"] == answer.status
    return answer.json["app"], answer.json["error"], answer.status


@pytest.mark.slow
@BOTH
@pytest.mark.parametrize(
    "arguments, kind",
    [
        (["green-serch"], "unknown-app"),
        (["green-search", "--set", "speed_m_s"], "usage"),
        ([], "usage"),
    ],
)
def test_a_wrong_command_is_reported_in_json_and_on_stderr(
    cli: Cli, command: str, arguments: list[str], kind: str, check_text: CheckText
) -> None:
    answer = cli(command, *arguments, "--json")
    app, _, exit_status = _answer(answer)
    assert (app, answer.json["kind"], exit_status) == ("".join(arguments[:1]), kind, 2)
    assert command == "sweep" or answer.json["outcome"] == "error"
    check_text(answer.err)


@pytest.mark.slow
@BOTH
def test_an_app_file_that_cannot_be_imported_is_reported_with_its_traceback(
    cli: Cli, command: str, check_text: CheckText
) -> None:
    Path("odd.py").write_text("x = (\n")
    answer = cli(command, "odd.py", "--json")
    assert _answer(answer) == ("odd.py", answer.err.splitlines()[-1].removeprefix("error: "), 5)
    check_text(answer.json["error"])
    assert re.match(r' +File ".*odd\.py", line 1\n +x = \(\n', answer.err), "and nothing of what imports it"


def test_a_missing_backend_is_reported_with_its_remedy(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("drivers.kinematic.backend.KinematicBackend.modules", ("no_such_simulator",))
    app, error, status = _answer(cli("run", "green-search", "--json"))
    assert (app, status) == ("green-search", 3)
    check_text(error)


@pytest.mark.slow
def test_a_refused_folder_and_a_failing_backend_are_reported(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise BackendError("the simulator has gone")

    Path("thesis").mkdir()
    Path("thesis/chapter.tex").touch()
    refused = cli("sweep", "green-search", "--out", "thesis", "--json")
    assert (refused.status, refused.json["error"].split()[0]) == (2, "thesis")
    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine.perform", fail)
    assert _answer(cli("sweep", "green-search", "--json")) == ("green-search", "the simulator has gone", 3)


@pytest.mark.slow
@BOTH
def test_without_json_nothing_is_on_stdout(cli: Cli, command: str, check_text: CheckText) -> None:
    answer = cli(command, "green-serch")
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


@pytest.mark.slow
@BOTH
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_before_the_first_run_is_reported_in_json(
    cli: Cli, command: str, number: signal.Signals, check_text: CheckText
) -> None:
    process = {"run": "os.getpid()", "sweep": SWEEP_ID}[command]  # a sweep looks at the app in another process
    Path("odd.py").write_text(f"import os\nos.kill({process}, {int(number)})\nwhile True: ...\n")
    answer = cli(command, "odd.py", "--json")
    app, _, status = _answer(answer)
    assert (app, status) == ("odd.py", 128 + number)
    check_text(answer.err)


@pytest.mark.slow
@BOTH
def test_prints_of_an_imported_app_stay_out_of_the_json(cli: Cli, command: str, check_text: CheckText) -> None:
    Path("odd.py").write_text("print('hello')\n1 / 0\n")
    answer = cli(command, "odd.py", "--json")
    assert answer.json["exit_status"] == 5
    check_text(answer.plain_err)


@pytest.mark.slow
def test_a_full_disk_does_not_change_the_exit_status() -> None:
    command = [sys.executable, "-m", "robotcore", "sweep", "green-serch", "--json"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [done.stderr.strip()]
    assert done.stderr.startswith("error: unknown app 'green-serch'")


@pytest.mark.slow
def test_apps_of_a_class_can_be_graded_if_one_of_them_is_broken(cli: Cli) -> None:
    works = "from robotcore import Behaviour, Status\nclass Ready(Behaviour):\n"
    Path("ann.py").write_text(f"{works}    def step(self, robot):\n        return Status.SUCCESS\n")
    Path("bob.py").write_text(f"{works}    def step(self, robot)\n")
    answer = [
        cli("sweep", app, "--world", "open", "--seeds", "1", "--jobs", "1", "--json") for app in ("ann.py", "bob.py")
    ]
    grades = [json.loads(line) for each in answer for line in each.out.splitlines()]
    assert [(grade["app"], "error" in grade) for grade in grades] == [("ann.py", False), ("bob.py", True)]

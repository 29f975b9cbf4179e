from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

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
    assert cli(command, *arguments) == (2, "", answer.err)


@pytest.mark.slow
@BOTH
@pytest.mark.parametrize("text", ["x = (\n", "print('hello')\n1 / 0\n"], ids=["syntax", "import"])
def test_an_app_file_that_cannot_be_imported_is_reported_with_its_own_traceback_and_its_prints(
    cli: Cli, command: str, text: str, check_text: CheckText
) -> None:
    Path("odd.py").write_text(text)
    answer = cli(command, "odd.py", "--json")
    assert _answer(answer) == ("odd.py", answer.err.splitlines()[-1].removeprefix("error: "), 5)
    check_text(answer.plain_err)


def test_a_missing_backend_is_reported_with_its_remedy(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("drivers.kinematic.backend.KinematicBackend.modules", ("no_such_simulator",))
    app, error, status = _answer(cli("run", "green-search", "--json"))
    assert (app, status) == ("green-search", 3)
    check_text(error)


@pytest.mark.slow
@BOTH
def test_a_signal_before_the_first_run_is_reported_in_json(cli: Cli, command: str, check_text: CheckText) -> None:
    process = {"run": "os.getpid()", "sweep": SWEEP_ID}[command]  # a sweep looks at the app in another process
    Path("odd.py").write_text(f"import os\nos.kill({process}, {signal.SIGTERM:d})\nwhile True: ...\n")
    answer = cli(command, "odd.py", "--json")
    app, _, status = _answer(answer)
    assert (app, status) == ("odd.py", 143)
    check_text(answer.err)


@pytest.mark.slow
def test_a_full_disk_does_not_change_the_exit_status() -> None:
    command = [sys.executable, "-m", "robotcore", "sweep", "green-serch", "--json"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [done.stderr.strip()]
    assert done.stderr.startswith("error: unknown app 'green-serch'")

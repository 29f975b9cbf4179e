from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys

import click
import pytest

from robotcore.cli.main import robotcore, run_app
from tests.robotcore.cli.conftest import AppFile, Cli

HEAVY = ("numpy", "cv2", "pydantic", "rich")


def test_help_lists_every_command_with_a_whole_line_about_it(cli: Cli) -> None:
    answer = cli("--help")
    context = click.Context(robotcore)
    assert answer.status == 0
    for name in robotcore.list_commands(context):
        line = next(line for line in answer.out.splitlines() if line.startswith(f"  {name} "))
        assert line.endswith(".")
        assert not line.endswith("...")


def test_no_arguments_show_the_help(cli: Cli) -> None:
    assert cli() == cli("--help")


def test_every_command_explains_itself(cli: Cli) -> None:
    for name in robotcore.list_commands(click.Context(robotcore)):
        assert cli(name, "--help").out.startswith(f"Usage: robotcore {name}")


def test_version_names_the_program(cli: Cli) -> None:
    assert cli("--version").out.startswith("robotcore ")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from robotcore.cli.main import execute; execute(['--help']); "
        f"sys.exit(' '.join(name for name in {HEAVY} if name in sys.modules) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_unknown_command_offers_the_nearest(cli: Cli) -> None:
    assert cli("bakends") == (2, "", "error: unknown command 'bakends'. Did you mean 'backends'?\n")


def test_unknown_option_is_reported_in_two_lines(cli: Cli) -> None:
    answer = cli("run", "--sead", "3")
    assert answer.status == 2
    assert answer.err.startswith("error: No such option")
    assert answer.err.splitlines()[1] == "Try 'robotcore run --help'."


def test_a_pipe_that_is_closed_early_is_no_noise() -> None:
    command = [sys.executable, "-m", "robotcore", "worlds"]
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as closed:
        done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "")


def test_interrupted_outside_a_run_is_128_plus_sigint(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted() -> list[str]:
        raise KeyboardInterrupt

    monkeypatch.setattr("robotcore.plugins.backend_names", interrupted)
    assert cli("backends").status == 130


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_process_that_was_interrupted_dies_of_the_signal_with_all_reported(app_file: AppFile, number: int) -> None:
    command = [sys.executable, "-m", "robotcore", "run", app_file(f"os.kill(os.getpid(), {int(number)})"), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (-number, "")
    assert json.loads(done.stdout)["exit_status"] == 128 + number


def test_what_an_app_has_half_written_is_not_lost_with_the_process(app_file: AppFile) -> None:
    halves = "import sys; sys.stdout.write('half'); sys.stderr.write('half')"
    deed = f"{halves}; os.kill(os.getpid(), {signal.SIGTERM:d})"
    command = [sys.executable, "-m", "robotcore", "run", app_file(deed)]
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    done = subprocess.run(command, env=buffered, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (-signal.SIGTERM, "half")
    assert done.stdout.startswith("half")


@pytest.mark.skipif(not shutil.which("bash"), reason="there is no bash")
def test_ctrl_c_ends_a_shells_loop_too(app_file: AppFile) -> None:
    line = shlex.join([sys.executable, "-m", "robotcore", "run", app_file("os.killpg(0, signal.SIGINT)")])
    loop = ["bash", "-c", f"for each in 1 2; do {line}; done; echo went on"]
    done = subprocess.run(loop, start_new_session=True, capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGINT
    assert done.stdout.count("interrupted by SIGINT") == 1
    assert "went on" not in done.stdout


def test_an_app_file_runs_itself_with_the_arguments_of_the_process(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["green_search.py", "--backend", "nowhere"])
    with pytest.raises(SystemExit) as ended:
        run_app("green-search")
    assert ended.value.code == 2
    assert "unknown backend 'nowhere'" in capfd.readouterr().err

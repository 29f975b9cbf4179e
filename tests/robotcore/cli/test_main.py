from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from inspect import cleandoc

import click
import pytest

from robotcore.cli.main import robotcore, run_app
from robotcore.runtime.signals import END_SIGNALS
from tests.robotcore.cli.conftest import AppFile, Cli
from tests.texts import CheckText

HEAVY = ("numpy", "cv2", "pydantic", "rich")


def test_help_lists_every_command_with_a_complete_sentence(cli: Cli) -> None:
    answer = cli("--help")
    context = click.Context(robotcore)
    assert answer.status == 0
    for name in robotcore.list_commands(context):
        line = next(line for line in answer.out.splitlines() if line.startswith(f"  {name} "))
        assert line.endswith(".")
        assert not line.endswith("...")


def test_no_arguments_show_the_help(cli: Cli) -> None:
    assert cli() == cli("--help")


def list_commands(group: click.Group = robotcore, *above: str) -> list[tuple[str, ...]]:
    """Return the names of each command and subcommand."""
    names: list[tuple[str, ...]] = []
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        names.append((*above, name))
        if isinstance(command, click.Group):
            names += list_commands(command, *above, name)
    return names


@pytest.mark.parametrize("names", list_commands(), ids=" ".join)
def test_every_command_has_a_help_text(cli: Cli, names: tuple[str, ...], check_text: CheckText) -> None:
    """The snapshot has the texts of the command, but not their layout, which depends on click's version."""
    command: click.Command = robotcore
    for name in names:
        assert isinstance(command, click.Group)
        command = command.get_command(click.Context(command), name) or command
    options = (each for each in command.params if isinstance(each, click.Option))
    check_text(
        "\n".join([f"{cleandoc(command.help or '')}\n", *(f"{' '.join(each.opts)}: {each.help}" for each in options)])
    )
    assert cli(*names, "--help").out.startswith(f"Usage: robotcore {' '.join(names)} ")


def test_version_names_the_program(cli: Cli) -> None:
    assert cli("--version").out.startswith("robotcore ")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from robotcore.cli.main import execute; execute(['--help']); "
        f"sys.exit(' '.join(name for name in {HEAVY} if name in sys.modules) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_for_an_unknown_command_the_nearest_name_is_suggested(cli: Cli, check_text: CheckText) -> None:
    answer = cli("bakends")
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


def test_for_an_option_without_its_value_the_help_of_the_command_is_named(cli: Cli) -> None:
    assert "'robotcore run --help'" in cli("run", "--backend").err


@pytest.mark.parametrize("option", ["--sead", "--runs"])
def test_for_an_unknown_option_only_a_near_name_is_suggested(cli: Cli, option: str, check_text: CheckText) -> None:
    answer = cli("sweep", "avoid-obstacles", option, "40")
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


@pytest.mark.slow
def test_a_closed_pipe_prints_no_error() -> None:
    command = [sys.executable, "-m", "robotcore", "worlds"]
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as closed:
        done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "")


def test_an_interrupt_outside_a_run_has_exit_status_128_plus_sigint(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted() -> list[str]:
        raise KeyboardInterrupt

    monkeypatch.setattr("robotcore.plugins.backend_names", interrupted)
    assert cli("backends").status == 130


@pytest.mark.slow
@pytest.mark.parametrize("number", END_SIGNALS[:3])
def test_an_interrupted_process_reports_the_signal_and_ends_by_it(app_file: AppFile, number: int) -> None:
    command = [sys.executable, "-m", "robotcore", "run", app_file(f"os.kill(os.getpid(), {int(number)})"), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (-number, "")
    assert json.loads(done.stdout)["exit_status"] == 128 + number


@pytest.mark.slow
def test_buffered_output_is_written_before_the_process_ends(app_file: AppFile) -> None:
    halves = "import sys; sys.stdout.write('half'); sys.stderr.write('half')"
    statement = f"{halves}; os.kill(os.getpid(), {signal.SIGTERM:d})"
    command = [sys.executable, "-m", "robotcore", "run", app_file(statement)]
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    done = subprocess.run(command, env=buffered, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (-signal.SIGTERM, "half")
    assert done.stdout.startswith("half")


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("bash"), reason="there is no bash")
def test_ctrl_c_also_ends_a_loop_of_the_shell(app_file: AppFile) -> None:
    line = shlex.join([sys.executable, "-m", "robotcore", "run", app_file("os.killpg(0, signal.SIGINT)")])
    loop = ["bash", "-c", f"for each in 1 2; do {line}; done; echo went on"]
    done = subprocess.run(loop, start_new_session=True, capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGINT
    assert done.stdout.count("interrupted by SIGINT") == 1
    assert "went on" not in done.stdout


@pytest.fixture
def without_exit_limit() -> Iterator[None]:
    """Cancel the timer that limits the exit of the process, because the process of the tests continues."""
    yield
    for thread in threading.enumerate():
        if isinstance(thread, threading.Timer):
            thread.cancel()


@pytest.mark.usefixtures("without_exit_limit")
def test_an_app_file_runs_itself_with_the_arguments_of_the_process(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    monkeypatch.setattr(sys, "argv", ["green_search.py", "--backend", "nowhere"])
    with pytest.raises(SystemExit) as ended:
        run_app("green-search")
    assert ended.value.code == 2
    check_text(capfd.readouterr().err)


SLOW_EXIT = """
import ctypes
from robotcore.cli import main

libc = ctypes.CDLL(None)
libc.on_exit(libc.getchar, None)  # a library that ends slowly: it waits for the standard input
main.EXITING_S = 0.1
main._exit(3)
"""


@pytest.mark.slow
def test_library_that_ends_slowly_keeps_the_exit_status() -> None:
    with (
        subprocess.Popen([sys.executable, "-c", SLOW_EXIT], stdin=subprocess.PIPE) as process,
        pytest.raises(subprocess.TimeoutExpired),
    ):
        process.wait(2.0)
    assert process.returncode == 3

"""``robotcore replay --watch`` and ``--record``."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from time import sleep
from unittest.mock import Mock

import pytest

from robotcore import Outcome
from robotcore.cli import replay_watch
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording import read
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.recording.conftest import record
from tests.texts import CheckText

APP = """
from robotcore import Behaviour, Role, Status

class Ahead(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        robot.drive.set_velocity(0.1, 0.0)
        return Status.RUNNING
"""
LOGGING = APP.replace("        return", '        robot.log("time", robot.clock.now(), "s")\n        return')


WAITING = APP.replace("        return", "        __import__('time').sleep(100)\n        return")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with an app and the recording of its run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ahead.py").write_text(APP)
    record(tmp_path / "run.mcap", app="ahead.py", timeout_s=0.3)
    return tmp_path


class Watch:
    """A process of ``robotcore replay run.mcap --watch ahead.py``."""

    def __init__(self, *options: str) -> None:
        command = [sys.executable, "-m", "robotcore", "replay", "run.mcap", "--watch", "ahead.py", *options]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, stdout=pipe, stderr=subprocess.STDOUT, text=True, start_new_session=True
        )

    def read_answer(self, end: str = "Watching ") -> str:
        """Return the output up to the line that begins with ``end``."""
        assert self.process.stdout
        lines = list[str]()
        while not lines or not lines[-1].startswith(end):
            line = self.process.stdout.readline()
            assert line, "".join(lines)
            lines.append(line)
        return "".join(lines)


@pytest.fixture
def watch(folder: Path) -> Iterator[Watch]:
    watching = Watch("--record", "again.mcap")
    yield watching
    watching.process.kill()
    watching.process.wait()


@pytest.mark.slow
def test_replay_runs_again_after_each_save_until_ctrl_c(folder: Path, watch: Watch) -> None:
    app = folder / "ahead.py"
    assert watch.read_answer().startswith("bit-equal")
    app.write_text(f"{APP}\ndef (")
    assert "SyntaxError" in watch.read_answer()
    app.write_text("import os\nos._exit(0)\n")
    watch.read_answer()
    app.write_text(APP.replace("0.1", "0.2"))
    assert watch.read_answer().startswith("differs")
    app.unlink()
    (folder / "new.py").write_text(LOGGING)
    (folder / "new.py").rename(app)
    answer = watch.read_answer()
    assert answer.startswith("bit-equal")
    assert "0.3 s" in answer
    assert len(read(folder / "again.mcap").logged) == 7
    watch.process.send_signal(signal.SIGINT)
    assert watch.process.wait(10) == -signal.SIGINT
    assert watch.process.communicate()[0] == ""


@pytest.mark.slow
@pytest.mark.parametrize("is_of_terminal", [False, True])
def test_ctrl_c_during_a_replay_completes_its_recording(folder: Path, *, is_of_terminal: bool) -> None:
    (folder / "ahead.py").write_text(WAITING)
    again = folder / "again.mcap"
    watching = Watch("--record", "again.mcap")
    while not again.exists() or not again.stat().st_size:
        assert watching.process.poll() is None
        sleep(0.1)
    if is_of_terminal:
        os.killpg(watching.process.pid, signal.SIGINT)
    else:
        watching.process.send_signal(signal.SIGINT)
    answer, _ = watching.process.communicate()
    assert watching.process.returncode == -signal.SIGINT
    recording = read(again)
    assert not recording.is_cut
    assert recording.result
    assert recording.result.outcome is Outcome.INTERRUPTED
    assert "\nThe recording: again.mcap\n" in answer


@pytest.mark.slow
def test_command_that_ignores_a_signal_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.cli.replay_watch.END_S", 0.1)
    monkeypatch.setattr("robotcore.cli.replay_watch.FORWARDED_END_S", 0.1)
    program = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); print(flush=True); signal.pause()"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE) as child:
        assert child.stdout
        child.stdout.readline()
        replay_watch._end(child, signal.SIGINT)
    assert child.returncode == -signal.SIGKILL


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--force", "--record=run.mcap", "--set=length=5"])
def test_usage_error_of_the_first_replay_ends_the_watch(folder: Path, option: str) -> None:
    watching = Watch(option)
    answer, _ = watching.process.communicate()
    assert watching.process.returncode == 2
    assert answer.startswith("error: ")
    assert answer.count("\n") == 1


def test_replay_waits_while_an_editor_writes(tmp_path: Path) -> None:
    app = tmp_path / "ahead.py"
    app.write_text("saved")
    before = replay_watch._list_versions(app)

    class Clock(MonotonicClock):
        def sleep_until(self, deadline: float) -> bool:
            app.write_text("written while the watch waits")
            return True

    app.write_text("written before")
    assert not replay_watch._has_settled(app, before, Clock())
    assert replay_watch._has_settled(app, before, MonotonicClock())


def test_each_replay_of_a_watch_has_the_options_of_the_command(
    folder: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch_app = Mock(return_value=0)
    monkeypatch.setattr("robotcore.cli.replay_watch.watch_app", watch_app)
    outputs = [
        f"--{name}=again.{suffix}" for name, suffix in (("picture", "png"), ("record", "mcap"), ("junit", "xml"))
    ]
    cli("replay", "run.mcap", "--watch", "ahead.py", "--set", "length=5", *outputs, "--require-equal", "--json")
    given = ["replay", "--app=ahead.py", "--set=length=5", *outputs, "--require-equal", "--json"]
    _, first, later = watch_app.call_args.args
    assert first == [*given, "--", "run.mcap"]
    assert later == [*given, "--force", "--", "run.mcap"]


@pytest.mark.slow
def test_watch_works_without_the_current_folder_in_the_import_path(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    watching = Watch()
    assert watching.read_answer().startswith("bit-equal")
    watching.process.terminate()
    assert watching.process.communicate()[0] == ""


@pytest.mark.slow
def test_watch_with_json_writes_one_line_of_json_for_each_replay(folder: Path) -> None:
    watching = Watch("--json")
    assert json.loads(watching.read_answer("{"))["bit_equal"] is True
    (folder / "ahead.py").write_text(LOGGING)
    assert json.loads(watching.read_answer("{"))["logged"][0]["name"] == "time"
    watching.process.terminate()
    assert watching.process.communicate()[0] == ""


@pytest.mark.parametrize(
    "options",
    [
        ("--watch", "none.py"),
        ("--watch", "avoid-obstacles"),
        ("--watch", "ahead.py", "--app", "ahead.py"),
        ("--record", "run.mcap", "--force"),
        ("--record", "run.txt"),
        ("--force",),
    ],
    ids=" ".join,
)
def test_wrong_option_is_refused(folder: Path, cli: Cli, check_text: CheckText, options: tuple[str, ...]) -> None:
    before = (folder / "run.mcap").read_bytes()
    answer = cli("replay", "run.mcap", *options)
    assert answer.status == 2
    assert answer.out == ""
    check_text(answer.err)
    assert (folder / "run.mcap").read_bytes() == before


def test_replay_is_recorded_and_shows_the_logged_values(folder: Path, cli: Cli, check_text: CheckText) -> None:
    (folder / "ahead.py").write_text(LOGGING)
    answer = cli("replay", "run.mcap", "--app", "ahead.py", "--record", "again.mcap")
    assert answer.status == 0
    result = read(folder / "run.mcap").result
    assert result
    check_text(answer.out, hide=[result.trace_sha256])
    assert len(read(folder / "again.mcap").logged) == 7
    assert cli("replay", "run.mcap", "--app", "ahead.py", "--record", "again.mcap").status == 2
    assert cli("replay", "run.mcap", "--app", "ahead.py", "--record", "again.mcap", "--force").status == 0


def test_replay_whose_recording_cannot_be_written_has_exit_status_1(folder: Path, cli: Cli) -> None:
    (folder / "full.mcap").symlink_to("/dev/full")
    answer = cli("replay", "run.mcap", "--record", "full.mcap")
    assert answer.status != 0
    assert "full.mcap" in answer.err

"""The files of active runs: who may read and write them, and when they are deleted."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import pytest

from robotcore.runtime.active_runs import FOLDER, end_runs, list_active_runs, register_run
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import Outcome
from tests.robotcore.fakes import FunctionApp
from tests.robotcore.runs import Watcher
from tests.robotcore.safety.guardian.conftest import start as start  # noqa: PLC0414  a fixture
from tests.robotcore.safety.guardian.doubles import UNGUARDED, RecordingBackend, Start
from tests.robotcore.safety.guardian.guarded_run import run_on
from tests.texts import CheckText

pytestmark = pytest.mark.linux("it finds processes in /proc")


@pytest.fixture(autouse=True)
def runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a runtime folder and set a temporary folder, in which no other program registers runs."""
    for variable, name in (("XDG_RUNTIME_DIR", "runtime"), ("TMPDIR", "temporary")):
        (tmp_path / name).mkdir()
        monkeypatch.setenv(variable, str(tmp_path / name))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    return tmp_path / "runtime"


def find_files(runtime: Path) -> list[Path]:
    return sorted((runtime / FOLDER).glob("*"))


def register_in_other_process(*, robot: str = "rover", ignores_sigterm: bool = False) -> int:
    """Fork a process that registers a run and then waits for a signal. Return its PID."""
    reader, writer = os.pipe()
    if (process := os.fork()) == 0:
        signal.signal(signal.SIGTERM, signal.SIG_IGN if ignores_sigterm else signal.SIG_DFL)
        with register_run("raspberrypi", robot, {"port": Path("/dev/null")}):
            os.write(writer, b"\n")
            signal.pause()
    os.read(reader, 1)
    os.close(reader)
    os.close(writer)
    return process


def kill(process: int) -> None:
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)


def test_a_run_of_another_process_is_listed_with_the_absolute_path_of_its_robot(runtime: Path) -> None:
    process = register_in_other_process(robot="mine.toml")
    (run,) = list_active_runs()
    kill(process)
    assert (run.process, run.backend, run.robot) == (process, "raspberrypi", str(Path.cwd() / "mine.toml"))
    assert (dict(run.options), [run.file]) == ({"port": "/dev/null"}, find_files(runtime))


def test_the_file_of_a_killed_run_is_ignored_and_deleted(runtime: Path) -> None:
    kill(register_in_other_process())
    (file,) = find_files(runtime)
    with_another_pid = json.dumps({**json.loads(file.read_text()), "process": os.getppid()})
    assert list_active_runs() == []
    assert find_files(runtime) == []
    file.write_text(with_another_pid)  # that of a program that is no run
    assert list_active_runs() == []


@pytest.mark.parametrize("content", ["", "[]", '{"process": 1}'])
def test_an_incomplete_file_is_ignored(runtime: Path, content: str) -> None:
    with register_run("raspberrypi", "rover", {}):
        find_files(runtime)[0].write_text(content)
        assert list_active_runs() == []


def test_only_the_user_can_read_the_file_and_it_is_deleted_at_the_end(runtime: Path) -> None:
    with register_run("raspberrypi", "rover", {}):
        (file,) = find_files(runtime)
        assert (file.parent.stat().st_mode & 0o777, file.stat().st_mode & 0o777) == (0o700, 0o600)
    assert find_files(runtime) == []


def test_a_fork_of_the_run_does_not_delete_its_file(runtime: Path) -> None:
    context = register_run("raspberrypi", "rover", {})
    context.__enter__()
    if (process := os.fork()) == 0:
        context.__exit__(None, None, None)
        os._exit(0)
    os.waitpid(process, 0)
    assert find_files(runtime)
    context.__exit__(None, None, None)


def test_without_a_runtime_folder_the_temporary_folder_is_used(runtime: Path) -> None:
    runtime.rmdir()
    process = register_in_other_process()
    (run,) = list_active_runs()
    kill(process)
    assert run.file.parent == runtime.parent / "temporary" / f"{FOLDER}-{os.getuid()}"


def test_a_folder_that_others_can_write_to_is_not_used(runtime: Path) -> None:
    process = register_in_other_process()
    (runtime / FOLDER).chmod(0o770)
    runs = list_active_runs()
    kill(process)
    assert runs == []
    with register_run("raspberrypi", "rover", {}):
        assert len(find_files(runtime)) == 1  # that of the killed process


def test_a_symbolic_link_to_a_folder_is_not_used(runtime: Path, tmp_path: Path) -> None:
    (tmp_path / "theirs").mkdir(mode=0o700)
    for link in (runtime / FOLDER, tmp_path / "temporary" / f"{FOLDER}-{os.getuid()}"):
        link.symlink_to(tmp_path / "theirs")
    with pytest.raises(PermissionError), register_run("raspberrypi", "rover", {}):
        pass


@pytest.mark.slow
def test_the_end_of_a_run_waits_until_its_robot_is_closed(runtime: Path, start: Start) -> None:
    running = start("drives")
    assert end_runs(list_active_runs(), 60.0) == []
    assert running.actions[-1].startswith("close")
    assert running.read_result()["reason"] == "interrupted by SIGTERM"
    assert find_files(runtime) == []


@pytest.mark.slow
def test_a_suspended_run_is_ended(start: Start) -> None:
    running = start("drives")
    running.process.send_signal(signal.SIGSTOP)
    assert end_runs(list_active_runs(), 60.0) == []
    running.end()


@pytest.mark.slow
def test_runs_that_ignore_sigterm_are_killed_after_one_limit_for_all() -> None:
    processes = [register_in_other_process(ignores_sigterm=True) for _ in range(2)]
    runs = list_active_runs()
    assert end_runs(runs, 0.2) == runs
    assert [os.WTERMSIG(os.waitpid(process, 0)[1]) for process in processes] == [signal.SIGKILL] * 2


@pytest.mark.parametrize("manner, count", [("good", 1), (UNGUARDED, 0)])
def test_only_a_run_with_cutoffs_is_registered(runtime: Path, tmp_path: Path, manner: str, count: int) -> None:
    seen: list[int] = []

    def step(_: object) -> Status:
        seen.append(len(find_files(runtime)))
        return Status.SUCCESS

    run_on(RecordingBackend(tmp_path / "diary", manner), FunctionApp(step), Watcher())
    assert (seen, find_files(runtime)) == ([count], [])


def test_a_run_that_cannot_be_registered_has_a_note(runtime: Path, tmp_path: Path, check_text: CheckText) -> None:
    for folder in (runtime, tmp_path / "temporary"):
        folder.rmdir()
    result = run_on(RecordingBackend(tmp_path / "diary"), FunctionApp(lambda _: Status.SUCCESS), Watcher())
    assert result.outcome is Outcome.SUCCESS
    (note,) = result.notes
    check_text(note, hide=[f"-{os.getuid()}'"])

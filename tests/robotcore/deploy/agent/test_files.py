from __future__ import annotations

import errno
import fcntl
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.deploy.agent import files, uploads
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, hold_lock
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, put_release, send_release
from tests.texts import Raises


def test_failed_write_keeps_the_old_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def is_full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    file = tmp_path / "health-check.json"
    files.write_file(file, "old")
    monkeypatch.setattr(os, "fsync", is_full)
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
        files.write_file(file, "new")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("health-check.json", "old")]


def test_link_is_replaced_after_an_interrupted_attempt(tmp_path: Path) -> None:
    link = tmp_path / "current"
    files.replace_link(link, "releases/old")
    tmp_path.joinpath(f".current.{os.getpid()}").symlink_to("releases/half")
    files.replace_link(link, "releases/new")
    assert [(path.name, str(path.readlink())) for path in tmp_path.iterdir()] == [("current", "releases/new")]


def test_content_is_synced_before_the_rename_and_the_folder_after_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[str, bool]] = []
    file, real = tmp_path / "health-check.json", os.fsync

    def record_sync(handle: int) -> None:
        seen.append((Path(f"/proc/self/fd/{handle}").readlink().name, file.exists()))
        real(handle)

    monkeypatch.setattr(os, "fsync", record_sync)
    files.write_file(file, "new")
    assert seen == [(f".health-check.json.{os.getpid()}", False), (tmp_path.name, True)]


def test_child_with_the_handle_holds_the_lock_after_its_parent_has_ended(layout: Layout, raises: Raises) -> None:
    with hold_lock(layout, "installation") as handle:
        child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, pass_fds=(handle,))
    holder = f"installation, process {os.getpid()}"
    with child, raises(AgentError, "busy", hide=[os.getpid()], holder=holder), hold_lock(layout, "push", 0.2):
        pytest.fail("the child's work is not over")
    with hold_lock(layout, "push", 0.2):
        pass


def test_process_that_waited_for_a_removed_lock_file_locks_the_new_one(
    layout: Layout, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock_file = fcntl.flock

    def remove_and_lock(handle: int, operation: int) -> None:
        monkeypatch.undo()
        layout.lock.unlink()
        lock_file(handle, operation)

    monkeypatch.setattr(fcntl, "flock", remove_and_lock)
    with hold_lock(layout, "push", 10) as handle:
        assert os.fstat(handle).st_ino == layout.lock.stat().st_ino


BEGIN = """
import subprocess, sys
subprocess.run([sys.executable, "-c", '''
import sys
from pathlib import Path
from robotcore.deploy.agent import uploads
from robotcore.deploy.agent.files import Layout, hold_lock
uploads.open_upload(Layout(Path(sys.argv[1])), sys.argv[2])
''', *sys.argv[1:]], check=True)
print("begun", flush=True)
sys.stdin.read()
"""
"""A call of a push. It runs as long as its connection, which is the calling process."""


@pytest.fixture
def robot(layout: Layout) -> Layout:
    """A robot with an empty folder for uploads."""
    layout.incoming.mkdir(parents=True)
    return layout


def test_new_push_takes_over_a_broken_upload_and_deletes_the_others(robot: Layout) -> None:
    command = [sys.executable, "-c", BEGIN, str(robot.home), OLD]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as connection:
        assert connection.stdout
        assert connection.stdout.readline() == "begun\n"
        (robot.incoming / OLD / "half").write_text("sent")
        assert not any(uploads.open_upload(robot, NEW).iterdir()), "a running push keeps its upload"
        connection.kill()
    uploads.discard(robot, robot.incoming / NEW)
    for name in ("2026-01-01T00-00-00Z", f"gone-1-{OLD}"):
        send_release(robot, name)
    (robot.incoming / "a user's notes").write_text("")
    assert [path.name for path in uploads.open_upload(robot, NEW).iterdir()] == ["half"]
    assert {path.name for path in robot.incoming.iterdir()} == {NEW, f"{NEW}.pushed-by"}


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is kept from root")
def test_read_only_folder_can_be_deleted(robot: Layout) -> None:
    folder = put_release(robot, OLD)
    locked = folder / "project" / "locked"
    locked.mkdir()
    (locked / "file").touch()
    for path in (locked, folder):
        path.chmod(0o500)
    uploads.discard(robot, folder)
    assert not folder.exists()
    assert not any(robot.incoming.iterdir())


def test_deleted_link_keeps_its_target(robot: Layout, tmp_path: Path) -> None:
    (tmp_path / "kept").touch()
    link = robot.incoming / "link"
    link.symlink_to(tmp_path)
    uploads.discard(robot, link)
    assert not link.is_symlink()
    assert (tmp_path / "kept").exists()


def test_identity_of_a_process_is_alive_until_it_ends(tmp_path: Path) -> None:
    program = tmp_path / "a) S 1 (b"
    shutil.copy(str(shutil.which("cat")), program)
    with subprocess.Popen([program], stdin=subprocess.PIPE) as cat:
        named = uploads.identify_process(cat.pid)
        assert uploads.is_process_alive(named)
    assert not any(map(uploads.is_process_alive, (named, "", "boot x 1", "boot 0 1")))


def test_process_with_a_reused_number_has_another_identity() -> None:
    boot, pid, started = uploads.identify_process(os.getpid()).split()
    assert uploads.is_process_alive(f"{boot} {pid} {started}")
    assert int(started) > int(uploads.identify_process(1).split()[2])
    assert not uploads.is_process_alive(f"{boot} {pid} {int(started) - 1}")
    assert not uploads.is_process_alive(f"another-boot {pid} {started}")

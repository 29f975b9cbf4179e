from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.deploy.agent import uploads
from robotcore.deploy.agent.files import Layout
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, put_release, send_release

BEGIN = """
import subprocess, sys
subprocess.run([sys.executable, "-c", '''
import sys
from pathlib import Path
from robotcore.deploy.agent import uploads
from robotcore.deploy.agent.files import Layout
uploads.open_upload(Layout(Path(sys.argv[1])), sys.argv[2])
''', *sys.argv[1:]], check=True)
print("begun", flush=True)
sys.stdin.read()
"""
"""A call of a push. It runs as long as its connection, which is the calling process."""


@pytest.fixture(autouse=True)
def _room(layout: Layout) -> None:
    layout.incoming.mkdir(parents=True)


def start_push(layout: Layout, release: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", BEGIN, str(layout.home), release]
    connection = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert connection.stdout
    assert connection.stdout.readline() == "begun\n"
    return connection


def test_upload_of_a_running_push_is_kept(layout: Layout) -> None:
    with start_push(layout, OLD):
        (layout.incoming / OLD / "half").write_text("sent")
        assert not any(uploads.open_upload(layout, NEW).iterdir())
        assert (layout.incoming / OLD / "half").exists()


def test_new_push_takes_over_a_broken_upload(layout: Layout) -> None:
    with start_push(layout, OLD) as connection:
        (layout.incoming / OLD / "half").write_text("sent")
        connection.kill()
    assert [path.name for path in uploads.open_upload(layout, NEW).iterdir()] == ["half"]
    assert not (layout.incoming / OLD).exists()


def test_other_broken_uploads_are_deleted(layout: Layout) -> None:
    for name in ("2026-01-01T00-00-00Z", OLD, f"gone-1-{OLD}"):
        send_release(layout, name)
    (layout.incoming / "a user's notes").write_text("")
    uploads.open_upload(layout, NEW)
    assert {path.name for path in layout.incoming.iterdir()} == {NEW, f"{NEW}.pushed-by"}


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is kept from root")
def test_read_only_folder_can_be_deleted(layout: Layout) -> None:
    folder = put_release(layout, OLD)
    locked = folder / "project" / "locked"
    locked.mkdir()
    (locked / "file").touch()
    for path in (locked, folder):
        path.chmod(0o500)
    uploads.discard(layout, folder)
    assert not folder.exists()
    assert not any(layout.incoming.iterdir())


def test_deleted_link_keeps_its_target(layout: Layout, tmp_path: Path) -> None:
    (tmp_path / "kept").touch()
    link = layout.incoming / "link"
    link.symlink_to(tmp_path)
    uploads.discard(layout, link)
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

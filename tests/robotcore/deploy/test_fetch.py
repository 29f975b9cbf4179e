from __future__ import annotations

import os
from pathlib import Path

import pytest

from robotcore.deploy.fetch import FetchResult, IncomingFiles, fetch
from robotcore.deploy.progress import StepProgress
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError, UsageError
from robotcore.text import escape
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd, slow_rsync
from tests.texts import Raises

FIRST, SECOND, THIRD = (f"2026-11-21T22-4{minute}-00Z.mcap" for minute in range(3))


@pytest.fixture
def remote_folder(link: RobotLink, robot: Sshd) -> Path:
    """The robot's folder, with two recordings of different content."""
    folder = robot.home / "robotcore" / "recordings"
    for name in (FIRST, SECOND):
        (folder / name).write_text(f"content of {name}")
    return folder


@pytest.fixture
def local_folder(tmp_path: Path) -> Path:
    return tmp_path / "recordings" / "my rover"


def list_file_names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def fetch_all(link: RobotLink, local_folder: Path, *, moves: bool = False) -> tuple[FetchResult, StepProgress]:
    steps: list[StepProgress] = []
    fetched = fetch(link, local_folder, steps.append, deletes_on_robot=moves)
    return fetched, steps[-1]


@pytest.mark.slow
def test_only_new_recordings_are_copied_and_moved_ones_are_deleted_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    (remote_folder / FIRST).chmod(0o6755)
    fetched, progress = fetch_all(link, local_folder)
    assert list_file_names(local_folder) == list_file_names(remote_folder) == [FIRST, SECOND]
    assert not (local_folder / FIRST).stat().st_mode & 0o7111
    assert (local_folder / SECOND).read_text() == f"content of {SECOND}"
    assert fetched.newest == local_folder / SECOND
    assert progress.text == f"2 recordings, 72 bytes, to {local_folder}"
    (remote_folder / THIRD).write_text("new")
    fetched, progress = fetch_all(link, local_folder, moves=True)
    assert (fetched.fetched, fetched.present) == ((THIRD,), (FIRST, SECOND))
    assert progress.text.startswith("1 recording, 3 bytes")
    assert (list_file_names(local_folder), list_file_names(remote_folder)) == ([FIRST, SECOND, THIRD], [])


def test_file_with_other_content_is_neither_overwritten_nor_deleted_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    local_folder.mkdir(parents=True)
    (local_folder / FIRST).write_text("mine")
    (local_folder / SECOND).write_text(f"CONTENT of {SECOND}")  # of the same length and time
    os.utime(local_folder / SECOND, (remote_folder / SECOND).stat()[-3:-1])
    before = {file.name: file.read_text() for file in local_folder.iterdir()}
    fetched, progress = fetch_all(link, local_folder, moves=True)
    assert {file.name: file.read_text() for file in local_folder.iterdir()} == before
    assert list_file_names(remote_folder) == [FIRST, SECOND]
    assert fetched.different == (FIRST, SECOND)
    assert FIRST in progress.details[0]


@pytest.mark.slow
def test_files_that_are_no_complete_recordings_are_named_and_stay_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    (remote_folder / "folder.mcap").mkdir()
    (remote_folder / "link.mcap").symlink_to("/etc/hostname")
    os.mkfifo(remote_folder / "pipe.mcap")
    misnamed = ["evil.py", ".hidden.mcap", "\x1b[2J.mcap", "-x.mcap"]
    for name in misnamed:
        (remote_folder / name).write_text("import os")
    left = {"folder.mcap", "link.mcap", "pipe.mcap", *misnamed}
    with (remote_folder / THIRD).open("w") as writer:
        writer.write("half")
        fetched, progress = fetch_all(link, local_folder, moves=True)
    assert list_file_names(local_folder) == [FIRST, SECOND]
    assert set(list_file_names(remote_folder)) == {*left, THIRD}
    assert fetched.being_written == (THIRD,)
    assert set(fetched.skipped) == {escape(name) for name in left}
    assert all(escape(name) in str(progress.details) for name in misnamed)
    assert THIRD in progress.details[0]
    assert "\x1b" not in str(progress)


def test_link_here_is_neither_followed_nor_replaced(
    link: RobotLink, remote_folder: Path, local_folder: Path, tmp_path: Path
) -> None:
    local_folder.mkdir(parents=True)
    (tmp_path / "mine.py").write_text("mine")
    (local_folder / FIRST).symlink_to(tmp_path / "mine.py")
    (local_folder / SECOND).symlink_to(tmp_path / "new.py")
    (local_folder / ".partial").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "elsewhere").mkdir()
    fetched, _ = fetch_all(link, local_folder, moves=True)
    assert fetched.different == (FIRST, SECOND)
    assert list_file_names(remote_folder) == [FIRST, SECOND]
    assert (tmp_path / "mine.py").read_text() == "mine"
    assert (local_folder / FIRST).is_symlink()
    assert not (tmp_path / "new.py").exists()


LISTED = """
def act(layout):
    return {{"recordings": [{{"name": {name!r}, "bytes": {size}, "is_file": True, "is_being_written": False}}]}}
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["link.mcap", "large.mcap"])
def test_file_that_differs_from_the_robots_list_is_not_kept(
    link: RobotLink, remote_folder: Path, local_folder: Path, add_action: AddAction, name: str
) -> None:
    (remote_folder / "link.mcap").symlink_to("/etc/hostname")
    (remote_folder / "large.mcap").write_bytes(bytes(1000))
    add_action("recordings", LISTED.format(name=name, size=5))
    with pytest.raises(DeployError):
        fetch_all(link, local_folder, moves=True)
    assert list_file_names(local_folder) == []
    assert (remote_folder / name).lstat()


@pytest.mark.slow
def test_transfer_ends_if_the_robot_sends_more_than_it_stated(
    link: RobotLink,
    remote_folder: Path,
    local_folder: Path,
    add_action: AddAction,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    (remote_folder / "large.mcap").write_bytes(bytes(30_000_000))
    add_action("recordings", LISTED.format(name="large.mcap", size=5))
    monkeypatch.setenv("PATH", str(slow_rsync(tmp_path / "slow")), prepend=os.pathsep)
    with pytest.raises(DeployError) as raised:
        fetch_all(link, local_folder)
    assert raised.value.kind == "too-many-bytes"
    assert list_file_names(local_folder) == []


def test_no_transfer_begins_if_the_disk_is_too_small(
    link: RobotLink, remote_folder: Path, local_folder: Path, add_action: AddAction
) -> None:
    add_action("recordings", LISTED.format(name="large.mcap", size=1 << 60))
    with pytest.raises(DeployError) as raised:
        fetch_all(link, local_folder)
    assert raised.value.kind == "no-room"
    assert list_file_names(local_folder) == []


@pytest.mark.slow
def test_complete_recordings_are_kept_after_an_error(
    link: RobotLink, remote_folder: Path, local_folder: Path, add_action: AddAction
) -> None:
    listed = [{"name": name, "bytes": 36, "is_file": True, "is_being_written": False} for name in (FIRST, "gone.mcap")]
    add_action("recordings", f"def act(layout):\n    return {{'recordings': {listed}}}\n")
    with pytest.raises(DeployError):
        fetch_all(link, local_folder)
    assert list_file_names(local_folder) == [FIRST]


def test_robot_without_recordings_makes_no_folder(link: RobotLink, remote_folder: Path, local_folder: Path) -> None:
    for file in remote_folder.iterdir():
        file.unlink()
    fetched, _ = fetch_all(link, local_folder)
    assert fetched.newest is None
    assert not local_folder.exists()


def test_links_and_too_long_leftovers_of_a_broken_fetch_are_deleted(tmp_path: Path) -> None:
    partial = tmp_path / ".partial"
    partial.mkdir()
    (partial / FIRST).symlink_to(tmp_path / "mine.py")
    (partial / SECOND).write_text("too long")
    (partial / THIRD).write_text("half")
    with IncomingFiles(tmp_path, {FIRST: 5, SECOND: 5, THIRD: 5}):
        assert list_file_names(partial) == [THIRD]


def test_leftover_that_cannot_be_deleted_stops_the_fetch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    (tmp_path / ".partial" / FIRST).mkdir(parents=True)
    monkeypatch.setattr("robotcore.deploy.fetch.delete", str)
    with raises(UsageError, "folder-not-writable"), IncomingFiles(tmp_path, {FIRST: 5}):
        pytest.fail("rsync may follow a link in the leftover")

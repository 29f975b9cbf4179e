from __future__ import annotations

import os
from pathlib import Path

import pytest

from robotcore.deploy.fetch import FetchResult, fetch
from robotcore.deploy.progress import StepProgress
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError
from robotcore.text import escape
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd, slow_rsync

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
    fetched = fetch(link, local_folder, steps.append, moves=moves)
    return fetched, steps[-1]


@pytest.mark.slow
def test_only_new_recordings_are_copied_and_moved_ones_are_deleted_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    fetched, progress = fetch_all(link, local_folder)
    assert list_file_names(local_folder) == list_file_names(remote_folder) == [FIRST, SECOND]
    assert (local_folder / SECOND).read_text() == f"content of {SECOND}"
    assert fetched.newest == local_folder / SECOND
    assert progress.text == f"2 recordings, 72 bytes, to {local_folder}"
    (remote_folder / THIRD).write_text("new")
    fetched, progress = fetch_all(link, local_folder, moves=True)
    assert (fetched.fetched, fetched.present) == ((THIRD,), (FIRST, SECOND))
    assert progress.text.startswith("1 recording, 3 bytes")
    assert (list_file_names(local_folder), list_file_names(remote_folder)) == ([FIRST, SECOND, THIRD], [])


def test_file_with_other_content_is_never_overwritten(link: RobotLink, remote_folder: Path, local_folder: Path) -> None:
    local_folder.mkdir(parents=True)
    (local_folder / FIRST).write_text("mine")
    fetched, progress = fetch_all(link, local_folder)
    assert (local_folder / FIRST).read_text() == "mine"
    assert fetched.different == (FIRST,)
    assert FIRST in progress.details[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["evil.py", ".hidden.mcap", "\x1b[2J.mcap", "-x.mcap"],
)
def test_file_without_the_name_of_a_recording_is_named_and_stays_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path, name: str
) -> None:
    (remote_folder / name).write_text("import os")
    fetched, progress = fetch_all(link, local_folder, moves=True)
    assert list_file_names(local_folder) == [FIRST, SECOND]
    assert list_file_names(remote_folder) == [name]
    assert fetched.skipped == (escape(name),)
    assert escape(name) in progress.details[-1]
    assert "\x1b" not in str(progress)


@pytest.mark.slow
def test_other_kinds_of_files_are_named_and_stay_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    (remote_folder / "folder.mcap").mkdir()
    (remote_folder / "link.mcap").symlink_to("/etc/hostname")
    os.mkfifo(remote_folder / "pipe.mcap")
    fetched, _ = fetch_all(link, local_folder, moves=True)
    assert fetched.skipped == ("folder.mcap", "link.mcap", "pipe.mcap")
    assert list_file_names(local_folder) == [FIRST, SECOND]
    assert list_file_names(remote_folder) == list(fetched.skipped)


def test_fetched_file_is_not_executable(link: RobotLink, remote_folder: Path, local_folder: Path) -> None:
    (remote_folder / FIRST).chmod(0o6755)
    fetch_all(link, local_folder)
    assert not (local_folder / FIRST).stat().st_mode & 0o7111


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
@pytest.mark.parametrize("name", ["link.mcap", "large.mcap", "absent.mcap"])
def test_file_that_differs_from_the_robots_list_is_not_kept(
    link: RobotLink, remote_folder: Path, local_folder: Path, add_action: AddAction, name: str
) -> None:
    (remote_folder / "link.mcap").symlink_to("/etc/hostname")
    (remote_folder / "large.mcap").write_bytes(bytes(1000))
    add_action("recordings", LISTED.format(name=name, size=5))
    with pytest.raises(DeployError):
        fetch_all(link, local_folder, moves=True)
    assert list_file_names(local_folder) == []
    assert name == "absent.mcap" or (remote_folder / name).lstat()


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


@pytest.mark.slow
def test_recording_with_other_content_here_is_not_deleted_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    fetch_all(link, local_folder)
    content = (local_folder / FIRST).read_text()
    (local_folder / FIRST).write_text(content.upper())
    os.utime(local_folder / FIRST, (remote_folder / FIRST).stat()[-3:-1])
    fetched, _ = fetch_all(link, local_folder, moves=True)
    assert fetched.different == (FIRST,)
    assert list_file_names(remote_folder) == [FIRST]
    assert (local_folder / FIRST).read_text() == content.upper()


def test_recording_that_is_being_written_stays_on_the_robot(
    link: RobotLink, remote_folder: Path, local_folder: Path
) -> None:
    with (remote_folder / THIRD).open("w") as writer:
        writer.write("half")
        fetched, progress = fetch_all(link, local_folder, moves=True)
    assert fetched.being_written == (THIRD,)
    assert list_file_names(remote_folder) == [THIRD]
    assert list_file_names(local_folder) == [FIRST, SECOND]
    assert THIRD in progress.details[0]


def test_robot_without_recordings_makes_no_folder(link: RobotLink, remote_folder: Path, local_folder: Path) -> None:
    for file in remote_folder.iterdir():
        file.unlink()
    fetched, _ = fetch_all(link, local_folder)
    assert fetched.newest is None
    assert not local_folder.exists()

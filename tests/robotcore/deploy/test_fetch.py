from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.link import Link
from robotcore.deploy.fetch import Fetched, fetch
from robotcore.deploy.progress import Progress
from tests.robotcore.deploy.sshd import serving

FIRST, SECOND, THIRD = (f"2026-11-21T22-4{minute}-00Z.mcap" for minute in range(3))


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Link, Path]]:
    with serving(tmp_path_factory.mktemp("robot") / "sshd") as server:
        recordings = server.home / "robotcore" / "recordings"
        recordings.mkdir(parents=True)
        with Link(Host(server.host), server.config) as link:
            yield link, recordings


@pytest.fixture
def link(robot: tuple[Link, Path]) -> Link:
    return robot[0]


@pytest.fixture
def there(robot: tuple[Link, Path]) -> Path:
    """The robot's recordings: two, each with content of its own."""
    for file in robot[1].iterdir():
        file.unlink()
    for name in (FIRST, SECOND):
        (robot[1] / name).write_text(f"what {name} saw")
    return robot[1]


@pytest.fixture
def here(tmp_path: Path) -> Path:
    return tmp_path / "recordings" / "my rover"


def names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def brought(link: Link, here: Path, *, moves: bool = False) -> tuple[Fetched, Progress]:
    told: list[Progress] = []
    fetched = fetch(link, here, told.append, moves=moves)
    return fetched, told[-1]


def test_what_is_not_here_is_brought_and_stays_there(link: Link, there: Path, here: Path) -> None:
    fetched, told = brought(link, here)
    assert names(here) == names(there) == [FIRST, SECOND]
    assert (here / SECOND).read_text() == f"what {SECOND} saw"
    assert fetched.newest == here / SECOND
    assert told.said == f"2 recordings, 68 bytes, to {here}"


def test_only_what_is_new_is_brought_again(link: Link, there: Path, here: Path) -> None:
    brought(link, here)
    (there / THIRD).write_text("new")
    fetched, told = brought(link, here)
    assert (fetched.brought, fetched.here) == ((THIRD,), (FIRST, SECOND))
    assert told.said.startswith("1 recording, 3 bytes")


def test_file_with_other_content_is_never_overwritten(link: Link, there: Path, here: Path) -> None:
    here.mkdir(parents=True)
    (here / FIRST).write_text("mine")
    fetched, told = brought(link, here)
    assert (here / FIRST).read_text() == "mine"
    assert fetched.different == (FIRST,)
    assert FIRST in told.notes[0]


def test_name_that_would_move_the_cursor_is_told_by_its_escapes(link: Link, there: Path, here: Path) -> None:
    here.mkdir(parents=True)
    (here / "\x1b[2J.mcap").write_text("mine")
    (there / "\x1b[2J.mcap").write_text("another")
    with (there / "\x1b[1A.mcap").open("w"):
        _, told = brought(link, here)
    assert ("\\x1b[2J.mcap" in str(told), "\\x1b[1A.mcap" in str(told)) == (True, True)
    assert "\x1b" not in str(told)


def test_what_is_moved_is_deleted_there(link: Link, there: Path, here: Path) -> None:
    brought(link, here)
    (there / THIRD).write_text("new")
    brought(link, here, moves=True)
    assert names(there) == []
    assert names(here) == [FIRST, SECOND, THIRD]


def test_what_differs_in_a_byte_is_not_deleted_there(link: Link, there: Path, here: Path) -> None:
    brought(link, here)
    content = (here / FIRST).read_text()
    (here / FIRST).write_text(content.upper())
    os.utime(here / FIRST, (there / FIRST).stat()[-3:-1])
    fetched, _ = brought(link, here, moves=True)
    assert fetched.different == (FIRST,)
    assert names(there) == [FIRST]
    assert (here / FIRST).read_text() == content.upper()


def test_what_is_being_written_stays_there(link: Link, there: Path, here: Path) -> None:
    with (there / THIRD).open("w") as writer:
        writer.write("half")
        fetched, told = brought(link, here, moves=True)
    assert fetched.written == (THIRD,)
    assert names(there) == [THIRD]
    assert names(here) == [FIRST, SECOND]
    assert "being written" in told.notes[0]


def test_robot_that_recorded_nothing_makes_no_folder(link: Link, there: Path, here: Path) -> None:
    for file in there.iterdir():
        file.unlink()
    fetched, _ = brought(link, here)
    assert fetched.newest is None
    assert not here.exists()

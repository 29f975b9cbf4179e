from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress

import pytest

from robotcore.deploy.agent.actions import begin, discard
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.current import names
from robotcore.deploy.agent.system import disk
from robotcore.deploy.agent.telling import RefusalError
from tests.robotcore.deploy.agent.released import NEW, NEWER, OLD, files_of, let_run, put, send

MOUNT = shutil.which("mount")


def test_the_first_push_has_nothing_to_copy_from(layout: Layout) -> None:
    assert begin.act(layout, release=NEW, size=1000) == {
        "release": NEW,
        "to": f"incoming/{NEW}",
        "copy_from": None,
    }
    assert (layout.incoming / NEW).is_dir()


def test_the_next_one_copies_from_what_runs(layout: Layout) -> None:
    for name in (OLD, NEW):
        put(layout, name)
    assert begin.act(layout, release=NEWER, size=1000)["copy_from"] == f"releases/{NEW}"
    let_run(layout, OLD)
    assert begin.act(layout, release=NEWER, size=1000)["copy_from"] == f"releases/{OLD}"


def test_two_pushes_at_once_have_a_name_and_a_folder_each(layout: Layout) -> None:
    told = [begin.act(layout, release=OLD, size=1000) for _ in range(3)]
    assert [each["release"] for each in told] == [OLD, NEW, NEWER]
    assert [each["to"] for each in told] == [f"incoming/{name}" for name in (OLD, NEW, NEWER)]


def test_a_push_from_a_desk_whose_clock_is_slow_is_the_newest_all_the_same(layout: Layout) -> None:
    put(layout, "2027-12-31T23-59-59Z")
    assert begin.act(layout, release=OLD, size=1000)["release"] == "2028-01-01T00-00-00Z"


def test_more_than_there_is_room_for_is_refused_and_nothing_is_left_of_it(layout: Layout) -> None:
    before = files_of(put(layout, OLD))
    let_run(layout, OLD)
    layout.recordings.mkdir()
    (layout.recordings / "long.mcap").write_bytes(bytes(2_000_000))
    with pytest.raises(RefusalError) as refused:
        begin.act(layout, release=NEW, size=10**15)
    assert refused.value.kind == "disk"
    assert "1000000.0 GB are to be sent" in refused.value.fault
    assert "recordings take 2.0 MB; robotcore deploy fetch --move takes them home" in refused.value.remedy
    assert files_of(layout.releases / OLD) == before
    assert not any(layout.incoming.glob(NEW))


def test_where_there_are_no_recordings_nobody_is_told_to_fetch_them(layout: Layout) -> None:
    with pytest.raises(RefusalError) as refused:
        begin.act(layout, release=NEW, size=10**15)
    assert refused.value.remedy == "Make room there: what takes it is told by df -h and du -xh ~ | sort -h"


def test_what_was_sent_can_be_thrown_away(layout: Layout) -> None:
    begin.act(layout, release=NEW, size=1000)
    send(layout, NEW)
    assert discard.act(layout, release=NEW) == {"discarded": True}
    assert discard.act(layout, release=NEW) == {"discarded": False}
    assert not any(layout.incoming.iterdir())


@pytest.fixture
def small(layout: Layout) -> Iterator[Layout]:
    """A robot whose disk has 130 MB."""
    if os.geteuid() or not MOUNT:
        pytest.skip("only root mounts a small disk")
    layout.root.mkdir(parents=True)
    if subprocess.run([MOUNT, "-t", "tmpfs", "-o", "size=130m", "none", layout.root], check=False).returncode:
        pytest.skip("nothing can be mounted here")
    yield layout
    subprocess.run([str(shutil.which("umount")), layout.root], check=True)


def test_on_a_disk_without_a_free_byte_old_releases_make_room(small: Layout) -> None:
    for name in (OLD, NEW, NEWER):
        (put(small, name) / "big").write_bytes(bytes(42_000_000 if name == OLD else 1000))
    let_run(small, NEW)
    fill(small)
    with pytest.raises(RefusalError, match="the robot's disk is full"):  # there is not enough for what stays free
        begin.act(small, release="2026-12-01T00-00-00Z", size=1000)
    assert names(small) == [NEWER, NEW]
    assert not any(small.incoming.iterdir())


def fill(robot: Layout) -> None:
    with (robot.root / "long.mcap").open("wb", buffering=0) as file, suppress(OSError):
        while True:
            file.write(bytes(1 << 16))
    assert disk.free_bytes(robot.root) == 0


def test_on_a_small_disk_old_releases_make_room(small: Layout) -> None:
    for name in (OLD, NEW, NEWER):
        (put(small, name) / "big").write_bytes(bytes(9_000_000))
    let_run(small, NEW)
    free = disk.free_bytes(small.root)
    begin.act(small, release="2026-12-01T00-00-00Z", size=free - begin.SPARE + 5_000_000)
    assert names(small) == [NEWER, NEW]
    assert disk.free_bytes(small.root) > free + 8_000_000

"""Without systemd: what it is told is written down by a program of its name."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.deploy.aboard.actions import remove
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.telling import RefusalError
from robotcore.deploy.aboard.units import SERVICE, TEXTS, TRIAL
from tests.robotcore.deploy.aboard.released import OLD, files_of, let_run, put

SYSTEMCTL = """#!/bin/sh
shift 2
echo "$@" >> "{folder}/told"
test "$1" = "$(cat "{folder}/refused" 2> /dev/null)" && echo "Failed to connect to bus" >&2 && exit 1
test "$1" = show && cat <<.
ActiveState=inactive
SubState=dead
Result=success
InvocationID=
NRestarts=0
StatusText=
ExecMainCode=0
ExecMainStatus=0
ActiveEnterTimestampMonotonic=0
UnitFileState=disabled
Job=
.
exit 0
"""


@pytest.fixture
def systemctl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder in which is ``told`` what systemctl was asked for; what it is to refuse is written to ``refused``."""
    folder = tmp_path / "bin"
    folder.mkdir()
    (folder / "systemctl").write_text(SYSTEMCTL.format(folder=folder))
    (folder / "systemctl").chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")
    return folder


@pytest.fixture
def robot(layout: Layout) -> Layout:
    put(layout, OLD)
    let_run(layout, OLD)
    layout.recordings.mkdir()
    (layout.recordings / "run.mcap").touch()
    layout.units.mkdir(parents=True)
    for name, text in TEXTS.items():
        (layout.units / name).write_text(text)
    return layout


def test_what_runs_is_stopped_before_anything_is_taken_away(robot: Layout, systemctl: Path) -> None:
    assert remove.act(robot) == {"removed": True, "kept": True}
    told = (systemctl / "told").read_text().splitlines()
    assert told[0] == f"stop {SERVICE} {TRIAL}"
    assert told[-1] == "daemon-reload"
    assert files_of(robot.home) == {"robotcore/recordings/run.mcap": b""}


def test_recordings_go_only_where_that_is_asked_for(robot: Layout, systemctl: Path) -> None:
    assert remove.act(robot, keeps_recordings=False) == {"removed": True, "kept": False}
    assert not robot.root.exists()
    assert remove.act(robot) == {"removed": False, "kept": False}


@pytest.mark.parametrize("refused", ["stop", "disable"])
def test_where_it_does_not_stop_all_is_still_there(robot: Layout, systemctl: Path, refused: str) -> None:
    before = files_of(robot.home)
    (systemctl / "refused").write_text(refused)
    with pytest.raises(RefusalError):
        remove.act(robot)
    assert files_of(robot.home) | {"robotcore/lock": b""} == before | {"robotcore/lock": b""}


def test_a_removal_that_was_cut_short_is_finished(robot: Layout, systemctl: Path) -> None:
    (robot.units / SERVICE).unlink()
    assert remove.act(robot)["removed"]
    assert not any(robot.units.iterdir())


def test_a_robot_that_a_push_broke_off_on_has_nothing_to_stop(layout: Layout, systemctl: Path) -> None:
    (layout.incoming / OLD).mkdir(parents=True)
    assert remove.act(layout) == {"removed": True, "kept": False}
    assert not (systemctl / "told").exists()
    assert not layout.root.exists()

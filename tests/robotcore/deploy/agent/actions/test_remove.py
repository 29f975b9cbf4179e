from __future__ import annotations

import pytest

from robotcore.deploy.agent.actions import remove
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.service.units import SERVICE, TEXTS, TRIAL
from robotcore.deploy.agent.telling import RefusalError
from tests.robotcore.deploy.agent import recorded as at
from tests.robotcore.deploy.agent.released import OLD, files_of, let_run, put
from tests.robotcore.deploy.agent.scripted import Scripted


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


def test_what_runs_is_stopped_before_anything_is_taken_away(robot: Layout, systemd: Scripted) -> None:
    assert remove.act(robot) == {"removed": True, "kept": True}
    assert systemd.calls[0] == f"stop {SERVICE} {TRIAL}"
    assert systemd.calls[-1] == "daemon-reload"
    assert files_of(robot.home) == {"robotcore/recordings/run.mcap": b""}


def test_recordings_go_only_where_that_is_asked_for(robot: Layout, systemd: Scripted) -> None:
    assert remove.act(robot, keeps_recordings=False) == {"removed": True, "kept": False}
    assert not robot.root.exists()
    assert remove.act(robot) == {"removed": False, "kept": False}


@pytest.mark.parametrize("refused", ["stop", "disable"])
def test_where_it_does_not_stop_all_is_still_there(robot: Layout, systemd: Scripted, refused: str) -> None:
    before = files_of(robot.home)
    systemd.fails(refused, at.NO_BUS)
    with pytest.raises(RefusalError):
        remove.act(robot)
    assert files_of(robot.home) | {"robotcore/lock": b""} == before | {"robotcore/lock": b""}


def test_a_removal_that_was_cut_short_is_finished(robot: Layout, systemd: Scripted) -> None:
    (robot.units / SERVICE).unlink()
    assert remove.act(robot)["removed"]
    assert not any(robot.units.iterdir())


def test_a_robot_that_a_push_broke_off_on_has_nothing_to_stop(layout: Layout, systemd: Scripted) -> None:
    (layout.incoming / OLD).mkdir(parents=True)
    assert remove.act(layout) == {"removed": True, "kept": False}
    assert not systemd.calls
    assert not layout.root.exists()

from __future__ import annotations

import os
from dataclasses import replace

import pytest

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.telling import RefusalError
from robotcore.deploy.agent.trial import trial
from robotcore.deploy.agent.trial.trial import Trial
from robotcore.deploy.agent.trial.watching import LeavingError
from tests.robotcore.deploy.agent import recorded as at
from tests.robotcore.deploy.agent.released import NEW, OLD, let_run, put
from tests.robotcore.deploy.agent.scripted import Scripted

LONG = 1000.0
RESTART = "restart --no-block robotcore.service"
STOP = "stop robotcore.service"
START_TRIAL = "start --no-block robotcore-trial.service"
DIES = (at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS, at.NEW_FAILS, at.NEW_WAITS)
LIVES = (at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS)


@pytest.fixture
def begun(layout: Layout, systemd: Scripted) -> Trial:
    """A new release on trial, in the place of an old one."""
    for name in (OLD, NEW):
        put(layout, name)
    let_run(layout, OLD)
    begun = Trial(NEW, OLD, LONG, 0.0, "2026-11-21T22:40:03Z")
    begun.begin(layout)
    systemd.folder.joinpath("calls").write_text("")
    return begun


def test_release_that_lives_stays(layout: Layout, systemd: Scripted, begun: Trial) -> None:
    systemd.will_tell(*LIVES)
    trial.conduct(layout)
    assert current.name_of(layout) == NEW
    assert begun.verdict(layout) == Verdict("healthy", since=begun.since)
    assert trial.pending(layout) is None
    assert systemd.calls == [RESTART]


def test_release_that_dies_makes_room_for_the_one_before(layout: Layout, systemd: Scripted, begun: Trial) -> None:
    Trial(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    systemd.will_tell(*DIES)
    systemd.writes("OSError: camera: no picture")
    trial.conduct(layout)
    assert current.name_of(layout) == OLD
    assert begun.verdict(layout) == Verdict(
        "unhealthy", "it ended with status 1", ("OSError: camera: no picture",), begun.since
    )
    assert trial.pending(layout) is None
    assert systemd.calls == [START_TRIAL, RESTART, STOP, RESTART]


def test_first_release_that_dies_leaves_nothing_running_now_or_after_a_reboot(
    layout: Layout, systemd: Scripted
) -> None:
    put(layout, NEW)
    Trial(NEW, None, LONG, LONG, "now").begin(layout)
    systemd.will_tell(at.NEVER_WAS, *DIES[1:])
    trial.conduct(layout)
    assert current.name_of(layout) is None
    assert systemd.calls == [START_TRIAL, RESTART, STOP, "disable robotcore.service"]


@pytest.mark.parametrize(
    "was_standing, was_enabled, after",
    [
        (True, False, ["disable robotcore.service"]),
        (True, True, []),
        (False, False, ["disable robotcore.service", RESTART]),
    ],
)
def test_release_before_is_found_again_as_it_was(
    layout: Layout, systemd: Scripted, begun: Trial, was_standing: bool, was_enabled: bool, after: list[str]
) -> None:
    replace(begun, settle_s=LONG, was_standing=was_standing, was_enabled=was_enabled).begin(layout)
    systemd.will_tell(at.PUT_OFF, *DIES[1:])
    systemd.fails("reset-failed", "Unit robotcore.service not loaded.")  # as of one that is disabled and down
    trial.conduct(layout)
    assert current.name_of(layout) == OLD
    assert systemd.calls == [START_TRIAL, RESTART, STOP, *after]
    forgotten = systemd.folder.joinpath("calls").read_text().splitlines().count("reset-failed robotcore.service")
    assert forgotten == 2 + after.count(RESTART), "the failure of the new one is none of the old one's"


def test_release_that_somebody_stops_is_taken_back_and_nothing_is_started(
    layout: Layout, systemd: Scripted, begun: Trial
) -> None:
    Trial(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    systemd.folder.joinpath("calls").write_text("")
    systemd.will_tell(*LIVES, at.STOPPED)
    trial.conduct(layout)
    assert current.name_of(layout) == OLD
    assert begun.verdict(layout) == Verdict("stopped", "somebody stopped it", since=begun.since)
    assert systemd.calls == [RESTART, STOP], "the new one, and nothing after it"


def test_reboot_leaves_the_trial_for_the_next_start(layout: Layout, systemd: Scripted, begun: Trial) -> None:
    Trial(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    systemd.folder.joinpath("system").write_text("stopping\n")
    systemd.will_tell(*LIVES, at.STOPPED)
    with pytest.raises(LeavingError):
        trial.conduct(layout)
    assert trial.pending(layout) == Trial(NEW, OLD, LONG, LONG, begun.since)
    assert begun.verdict(layout) is None


@pytest.mark.parametrize("verb", ["show", "restart"])
def test_systemd_that_goes_leaves_the_trial_for_the_next_start(
    layout: Layout, systemd: Scripted, begun: Trial, verb: str
) -> None:
    systemd.will_tell(*LIVES)
    systemd.fails(verb, at.LEFT)
    with pytest.raises(RefusalError):
        trial.conduct(layout)
    assert trial.pending(layout) == begun
    assert begun.verdict(layout) is None


def test_unit_that_systemd_does_not_take_is_a_release_that_does_not_live(
    layout: Layout, systemd: Scripted, begun: Trial
) -> None:
    """The restart that brings the old one back fails too: somebody has broken the unit, and is told."""
    systemd.will_tell(*LIVES)
    systemd.fails("restart", at.UNKNOWN)
    with pytest.raises(RefusalError, match="not found"):
        trial.conduct(layout)
    assert current.name_of(layout) == OLD
    verdict = begun.verdict(layout)
    assert verdict
    assert "Unit robotcore.service not found" in verdict.reason


def test_who_was_killed_after_the_verdict_is_followed_by_somebody_who_does_what_is_left(
    layout: Layout, systemd: Scripted, begun: Trial
) -> None:
    let_run(layout, NEW)
    Verdict("unhealthy", "it ended with status 1", (), begun.since).write(layout.releases / NEW)
    trial.conduct(layout)
    assert (current.name_of(layout), trial.pending(layout)) == (OLD, None)
    assert systemd.calls == [STOP, RESTART], "the old one: the new one is not tried once more"


def test_verdict_of_another_trial_is_none(layout: Layout, systemd: Scripted, begun: Trial) -> None:
    Verdict("unhealthy", "it ended with status 1", (), "2026-11-20T10:00:00Z").write(layout.releases / NEW)
    systemd.will_tell(*LIVES)
    trial.conduct(layout)
    assert current.name_of(layout) == NEW


def test_bad_release_is_taken_back_also_where_its_verdict_cannot_be_written(
    layout: Layout, systemd: Scripted, begun: Trial
) -> None:
    Trial(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    layout.releases.joinpath(NEW, "verdict.json").mkdir()
    systemd.will_tell(*DIES)
    trial.conduct(layout)
    assert (current.name_of(layout), trial.pending(layout)) == (OLD, None)


def test_bad_release_runs_no_more_where_no_link_can_be_made(layout: Layout, systemd: Scripted, begun: Trial) -> None:
    Trial(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    layout.releases.joinpath(NEW, "verdict.json").mkdir()
    in_the_way = layout.root / f".current.{os.getpid()}"
    systemd.will_tell(*DIES)
    systemd.then(len(DIES), f'mkdir "{in_the_way}"')
    for _ in range(2):
        with pytest.raises(OSError, match=in_the_way.name):
            trial.conduct(layout)
    assert systemd.calls == [START_TRIAL, RESTART, STOP], "nor does it when systemd starts the trial again"
    in_the_way.rmdir()
    systemd.folder.joinpath(f"then.robotcore.service.{len(DIES)}").unlink()
    systemd.will_tell(*DIES)
    trial.conduct(layout)
    assert (current.name_of(layout), trial.pending(layout)) == (OLD, None)


@pytest.mark.parametrize("known, stays", [("unhealthy", OLD), ("healthy", NEW)])
def test_verdict_that_is_known_is_kept_where_somebody_stops_what_is_left_to_do(
    layout: Layout, systemd: Scripted, begun: Trial, known: str, stays: str
) -> None:
    let_run(layout, NEW)
    (verdict := Verdict(known, "it is known why", (), begun.since)).write(layout.releases / NEW)
    trial.abandon(layout)
    assert (current.name_of(layout), trial.pending(layout)) == (stays, None)
    assert begun.verdict(layout) == verdict
    assert RESTART not in systemd.calls


def test_release_that_is_gone_changes_nothing(layout: Layout, systemd: Scripted) -> None:
    put(layout, OLD)
    let_run(layout, OLD)
    Trial(NEW, OLD, LONG, 0.0, "now").begin(layout)
    trial.conduct(layout)
    assert (current.name_of(layout), trial.pending(layout)) == (OLD, None)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"release": "../../etc", "previous": null}', '{"previous": null}'])
def test_file_that_tells_of_no_trial_is_none(layout: Layout, text: str) -> None:
    layout.root.mkdir(parents=True)
    layout.trial.write_text(text)
    assert trial.pending(layout) is None


def test_trial_that_systemd_does_not_take_has_not_begun(layout: Layout, systemd: Scripted) -> None:
    layout.root.mkdir(parents=True)
    systemd.fails("start", at.NO_BUS)
    with pytest.raises(RefusalError, match="loginctl enable-linger"):
        Trial(NEW, OLD).begin(layout)
    assert not layout.trial.exists()

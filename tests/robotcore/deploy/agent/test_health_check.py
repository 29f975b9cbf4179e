from __future__ import annotations

import os
from dataclasses import replace

import pytest

from robotcore.deploy.agent import health_check, releases, robot_facts
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck, ShutdownError
from robotcore.deploy.agent.releases import HealthResult
from robotcore.deploy.agent.rpc import AgentError
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, make_current, put_release
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd
from tests.texts import Raises

LONG = 1000.0
RESTART = "restart --no-block robotcore.service"
STOP = "stop robotcore.service"
START_TRIAL = "start --no-block robotcore-trial.service"
DIES = (at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS, at.NEW_FAILS, at.NEW_WAITS)
LIVES = (at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS)


@pytest.fixture
def begun(layout: Layout, systemd: ScriptedSystemd) -> HealthCheck:
    """A new release on trial, in the place of an old one."""
    for name in (OLD, NEW):
        put_release(layout, name)
    make_current(layout, OLD)
    begun = HealthCheck(NEW, OLD, LONG, 0.0, "2026-11-21T22:40:03Z")
    begun.begin(layout)
    systemd.folder.joinpath("calls").write_text("")
    return begun


def test_release_that_lives_stays(layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck) -> None:
    systemd.will_tell(*LIVES)
    health_check.run_check(layout)
    assert releases.read_current(layout) == NEW
    assert begun.read_result(layout) == HealthResult("healthy", since=begun.since)
    assert health_check.read_pending(layout) is None
    assert systemd.calls == [RESTART]


def test_release_that_dies_makes_room_for_the_one_before(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    systemd.will_tell(*DIES)
    systemd.writes("OSError: camera: no picture")
    health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    assert begun.read_result(layout) == HealthResult(
        "unhealthy", "it ended with status 1", ("OSError: camera: no picture",), begun.since
    )
    assert health_check.read_pending(layout) is None
    assert systemd.calls == [START_TRIAL, RESTART, STOP, RESTART]


def test_first_release_that_dies_leaves_nothing_running_now_or_after_a_reboot(
    layout: Layout, systemd: ScriptedSystemd
) -> None:
    put_release(layout, NEW)
    HealthCheck(NEW, None, LONG, LONG, "now").begin(layout)
    systemd.will_tell(at.NEVER_WAS, *DIES[1:])
    health_check.run_check(layout)
    assert releases.read_current(layout) is None
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
    layout: Layout,
    systemd: ScriptedSystemd,
    begun: HealthCheck,
    was_standing: bool,
    was_enabled: bool,
    after: list[str],
) -> None:
    replace(begun, settle_s=LONG, was_standing=was_standing, was_enabled=was_enabled).begin(layout)
    systemd.will_tell(at.PUT_OFF, *DIES[1:])
    systemd.fails("reset-failed", "Unit robotcore.service not loaded.")  # as of one that is disabled and down
    health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    assert systemd.calls == [START_TRIAL, RESTART, STOP, *after]
    forgotten = systemd.folder.joinpath("calls").read_text().splitlines().count("reset-failed robotcore.service")
    assert forgotten == 2 + after.count(RESTART), "the failure of the new one is none of the old one's"


def test_release_that_somebody_stops_is_taken_back_and_nothing_is_started(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    systemd.folder.joinpath("calls").write_text("")
    systemd.will_tell(*LIVES, at.STOPPED)
    health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    assert begun.read_result(layout) == HealthResult("stopped", "a user stopped it", since=begun.since)
    assert systemd.calls == [RESTART, STOP], "the new one, and nothing after it"


def test_reboot_leaves_the_trial_for_the_next_start(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    systemd.folder.joinpath("system").write_text("stopping\n")
    systemd.will_tell(*LIVES, at.STOPPED)
    with pytest.raises(ShutdownError):
        health_check.run_check(layout)
    assert health_check.read_pending(layout) == HealthCheck(NEW, OLD, LONG, LONG, begun.since)
    assert begun.read_result(layout) is None


@pytest.mark.parametrize("verb", ["show", "restart"])
def test_systemd_that_goes_leaves_the_trial_for_the_next_start(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck, verb: str
) -> None:
    systemd.will_tell(*LIVES)
    systemd.fails(verb, at.LEFT)
    with pytest.raises(AgentError):
        health_check.run_check(layout)
    assert health_check.read_pending(layout) == begun
    assert begun.read_result(layout) is None


def test_unit_that_systemd_does_not_take_is_a_release_that_does_not_live(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck, raises: Raises
) -> None:
    """The restart that brings the old one back fails too: somebody has broken the unit, and is told."""
    systemd.will_tell(*LIVES)
    systemd.fails("restart", at.UNKNOWN)
    with raises(AgentError, "systemctl"):
        health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    verdict = begun.read_result(layout)
    assert verdict
    assert "Unit robotcore.service not found" in verdict.reason


def test_who_was_killed_after_the_verdict_is_followed_by_somebody_who_does_what_is_left(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck
) -> None:
    make_current(layout, NEW)
    HealthResult("unhealthy", "it ended with status 1", (), begun.since).write(layout.releases / NEW)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)
    assert systemd.calls == [STOP, RESTART], "the old one: the new one is not tried once more"


def test_verdict_of_another_trial_is_none(layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck) -> None:
    HealthResult("unhealthy", "it ended with status 1", (), "2026-11-20T10:00:00Z").write(layout.releases / NEW)
    systemd.will_tell(*LIVES)
    health_check.run_check(layout)
    assert releases.read_current(layout) == NEW


def test_bad_release_is_taken_back_also_where_its_verdict_cannot_be_written(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    layout.releases.joinpath(NEW, "verdict.json").mkdir()
    systemd.will_tell(*DIES)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)


def test_bad_release_runs_no_more_where_no_link_can_be_made(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, begun.since).begin(layout)
    layout.releases.joinpath(NEW, "verdict.json").mkdir()
    in_the_way = layout.root / f".current.{os.getpid()}"
    systemd.will_tell(*DIES)
    systemd.then(len(DIES), f'mkdir "{in_the_way}"')
    for _ in range(2):
        with pytest.raises(OSError, match=in_the_way.name):
            health_check.run_check(layout)
    assert systemd.calls == [START_TRIAL, RESTART, STOP], "nor does it when systemd starts the trial again"
    in_the_way.rmdir()
    systemd.folder.joinpath(f"then.robotcore.service.{len(DIES)}").unlink()
    systemd.will_tell(*DIES)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)


@pytest.mark.parametrize("known, stays", [("unhealthy", OLD), ("healthy", NEW)])
def test_verdict_that_is_known_is_kept_where_somebody_stops_what_is_left_to_do(
    layout: Layout, systemd: ScriptedSystemd, begun: HealthCheck, known: str, stays: str
) -> None:
    make_current(layout, NEW)
    (verdict := HealthResult(known, "it is known why", (), begun.since)).write(layout.releases / NEW)
    health_check.abandon_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (stays, None)
    assert begun.read_result(layout) == verdict
    assert RESTART not in systemd.calls


def test_release_that_is_gone_changes_nothing(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    HealthCheck(NEW, OLD, LONG, 0.0, "now").begin(layout)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"release": "../../etc", "previous": null}', '{"previous": null}'])
def test_file_that_tells_of_no_trial_is_none(layout: Layout, text: str) -> None:
    layout.root.mkdir(parents=True)
    layout.health_check.write_text(text)
    assert health_check.read_pending(layout) is None


def test_trial_that_systemd_does_not_take_has_not_begun(
    layout: Layout, systemd: ScriptedSystemd, raises: Raises
) -> None:
    layout.root.mkdir(parents=True)
    systemd.fails("start", at.NO_BUS)
    with raises(AgentError, "manager", hide=[robot_facts.read_user(), os.getuid()]):
        HealthCheck(NEW, OLD).begin(layout)
    assert not layout.health_check.exists()


WORDS = ("Traceback (most recent call last):", "OSError: camera: no picture for 1 s. Look at its cable")


def test_release_that_came_up_and_stayed_is_healthy(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.OLD_STOPS, at.NEW_STARTS, at.NEW_RUNS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")
    assert systemd.calls == ["restart --no-block robotcore.service"], "one job: never neither"


def test_release_that_runs_already_is_not_taken_for_the_new_one(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.OLD_RUNS, at.OLD_STOPS, at.NEW_STARTS, at.NEW_FAILS, at.NEW_WAITS)
    assert health_check.watch_app(LONG, 0.0).outcome == "unhealthy"


def test_release_before_that_fails_and_is_just_started_again_is_not_taken_for_the_new_one(
    systemd: ScriptedSystemd,
) -> None:
    systemd.will_tell(at.OLD_WAITS, at.OLD_AGAIN, at.OLD_STOPS_AGAIN, at.NEW_STARTS, at.NEW_RUNS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")


@pytest.mark.parametrize(
    "looks, reason",
    [
        ((at.NEW_FAILS, at.NEW_WAITS), "it ended with status 1"),
        ((at.NEW_RUNS, at.NEW_FAILS, at.NEW_WAITS), "it ended with status 1"),
        ((at.UNUSABLE,), "it ended with status 2 (it cannot run as it is described)"),
        ((at.NEW_RUNS, at.NEW_WAITS.replace(" 1 1 ", " 1 5 ")), "it ended with status 5 (the app raised, or hung)"),
        ((at.NEW_RUNS, at.KILLED), "it was ended by SIGKILL"),
        ((at.NEW_RUNS, at.HANGS, at.HUNG), "it hung: it did not reset systemd's watchdog"),
        ((at.TOO_SLOW, at.WAS_TOO_SLOW), "it took too long to start or to stop"),
        ((at.NEVER_READY, at.WAS_NEVER_READY), "it ended with status 0 before its first step"),
        ((at.AGAIN_RUNS,), "it was started again"),
        ((at.NEW_RUNS, at.AGAIN_RUNS), "it was started again"),
        ((at.NEW_RUNS, at.BETWEEN, at.AGAIN_RUNS), "it was started again"),
    ],
)
def test_release_that_fails_is_unhealthy_and_reported_of_in_its_own_words(
    systemd: ScriptedSystemd, looks: tuple[str, ...], reason: str
) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, *looks)
    systemd.writes(*WORDS)
    assert health_check.watch_app(LONG, LONG) == HealthResult("unhealthy", reason, WORDS)
    assert "_SYSTEMD_INVOCATION_ID=0c7fb2b1ea3440b5ae86df6299644aee" in systemd.asked


def test_release_that_somebody_restarts_is_watched_from_there_on(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.BETWEEN, at.BACK_STARTS, at.BACK_RUNS, at.BACK_FAILS)
    systemd.writes(*WORDS)
    assert health_check.watch_app(LONG, LONG) == HealthResult("unhealthy", "it ended with status 1", WORDS)
    assert "_SYSTEMD_INVOCATION_ID=e67fb2b1ea3440b5ae86df6299644aee" in systemd.asked
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, at.BETWEEN, at.BACK_STARTS, at.BACK_RUNS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")


def test_start_that_failed_before_anybody_looked_is_not_missed(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.AGAIN_RUNS)
    assert health_check.watch_app(LONG, 0.0).outcome == "unhealthy"


def test_release_that_hangs_is_not_healthy_before_it_tells_that_it_is_alive(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, at.NEW_HANGS, at.NEW_HANGS, at.NEW_FAILS, at.NEW_WAITS)
    systemd.writes(*WORDS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("unhealthy", "it ended with status 1", WORDS)
    systemd.will_tell(at.OLD_RUNS, at.NEW_HANGS, at.NEW_HANGS, at.NEW_RUNS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")


def test_release_whose_watchdog_somebody_switched_off_is_healthy_in_the_end(
    systemd: ScriptedSystemd, monkeypatch: pytest.MonkeyPatch
) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_HANGS)
    monkeypatch.setattr(health_check, "NO_WATCHDOG_S", 0.0)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")


def test_last_words_are_those_of_a_process_that_has_ended(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.HANGS, at.HUNG)
    systemd.writes("release 2026-11-21T22-40-01Z: search.py on raspberrypi")
    systemd.then(4, "echo 'Fatal Python error: Aborted' > journal")
    assert health_check.watch_app(LONG, LONG).lines == ("Fatal Python error: Aborted",)


def test_release_that_is_not_ready_in_time_is_unhealthy(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS)
    assert health_check.watch_app(0.0, LONG) == HealthResult(
        "unhealthy",
        "its first step had not come back within 0 s; if it is only slow, push it with a longer --healthy-within",
    )


@pytest.mark.parametrize("within_s", [LONG, 0.0])
def test_release_that_ends_with_success_is_healthy_whenever_it_does(systemd: ScriptedSystemd, within_s: float) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.SUCCEEDS, at.SUCCEEDED)
    assert health_check.watch_app(within_s, LONG) == HealthResult("healthy", "it ended with success")


def test_release_that_somebody_stops_is_not_judged(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.STOPPED)
    assert health_check.watch_app(LONG, LONG) == HealthResult("stopped", "a user stopped it")


@pytest.mark.parametrize("system", ["stopping", "offline", ""])
@pytest.mark.parametrize("looks", [(at.NEW_RUNS, at.STOPPED), (at.NEW_RUNS, at.KILLED), (at.PASSED_OVER,)])
def test_release_that_ends_with_the_robot_is_not_judged_at_all(
    systemd: ScriptedSystemd, system: str, looks: tuple[str, ...]
) -> None:
    systemd.folder.joinpath("system").write_text(system)
    systemd.will_tell(at.OLD_RUNS, *looks)
    with pytest.raises(health_check.ShutdownError):
        health_check.watch_app(LONG, LONG)


def test_what_systemd_passes_over_is_unhealthy_at_once(systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.PASSED_OVER)
    assert health_check.watch_app(LONG, LONG) == HealthResult("unhealthy", "systemd did not start it")


def test_systemd_that_leaves_is_no_verdict(systemd: ScriptedSystemd, raises: Raises) -> None:
    systemd.will_tell(at.OLD_RUNS)
    systemd.fails("restart", at.LEFT)
    with raises(AgentError, "manager", hide=[robot_facts.read_user(), os.getuid()]):
        health_check.watch_app(LONG, LONG)

from __future__ import annotations

import os
from dataclasses import replace

import pytest

from robotcore.deploy.agent import health_check, releases, robot_facts
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck, ShutdownError
from robotcore.deploy.agent.releases import HealthResult
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, make_current, put_release, put_releases
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd
from tests.texts import CheckText, Raises

LONG = 1000.0
RESTART = "restart --no-block robotcore.service"
STOP = "stop robotcore.service"
START_CHECK = "start --no-block robotcore-health-check.service"
DIES = (at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS, at.NEW_FAILS, at.NEW_WAITS)
LIVES = (at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS)


@pytest.fixture
def check(layout: Layout, systemd: ScriptedSystemd) -> HealthCheck:
    """The pending check of a new release, with an old one to roll back to."""
    put_releases(layout, OLD, NEW, current=OLD)
    check = HealthCheck(NEW, OLD, LONG, 0.0, "2026-11-21T22:40:03Z")
    check.begin(layout)
    systemd.folder.joinpath("calls").write_text("")
    return check


def test_healthy_release_stays_current(layout: Layout, systemd: ScriptedSystemd, check: HealthCheck) -> None:
    systemd.set_states(*LIVES)
    health_check.run_check(layout)
    assert releases.read_current(layout) == NEW
    assert check.read_result(layout) == HealthResult("healthy", since=check.since)
    assert health_check.read_pending(layout) is None
    assert systemd.calls == [RESTART]


def test_failed_release_is_rolled_back(layout: Layout, systemd: ScriptedSystemd, check: HealthCheck) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, check.since).begin(layout)
    systemd.set_states(*DIES)
    systemd.set_lines("OSError: camera: no picture")
    health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    assert check.read_result(layout) == HealthResult(
        "unhealthy", "it ended with status 1", ("OSError: camera: no picture",), check.since
    )
    assert health_check.read_pending(layout) is None
    assert systemd.calls == [START_CHECK, RESTART, STOP, RESTART]


def test_failed_first_release_leaves_no_app_running(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    HealthCheck(NEW, None, LONG, LONG, "now").begin(layout)
    systemd.set_states(at.NEVER_WAS, *DIES[1:])
    health_check.run_check(layout)
    assert releases.read_current(layout) is None
    assert systemd.calls == [START_CHECK, RESTART, STOP, "disable robotcore.service"]


@pytest.mark.parametrize(
    "was_standing, was_enabled, after",
    [
        (True, False, ["disable robotcore.service"]),
        (True, True, []),
        (False, False, ["disable robotcore.service", RESTART]),
    ],
)
def test_rollback_restores_the_state_of_the_previous_release(
    layout: Layout,
    systemd: ScriptedSystemd,
    check: HealthCheck,
    was_standing: bool,
    was_enabled: bool,
    after: list[str],
) -> None:
    replace(check, settle_s=LONG, was_standing=was_standing, was_enabled=was_enabled).begin(layout)
    systemd.set_states(at.PUT_OFF, *DIES[1:])
    systemd.fail("reset-failed", "Unit robotcore.service not loaded.")  # for a disabled unit that is down
    health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    assert systemd.calls == [START_CHECK, RESTART, STOP, *after]
    forgotten = systemd.folder.joinpath("calls").read_text().splitlines().count("reset-failed robotcore.service")
    assert forgotten == 2 + after.count(RESTART), "the failures of the new release are reset"


def test_release_stopped_by_a_user_is_rolled_back_and_nothing_starts(
    layout: Layout, systemd: ScriptedSystemd, check: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, check.since).begin(layout)
    systemd.folder.joinpath("calls").write_text("")
    systemd.set_states(*LIVES, at.STOPPED)
    health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    assert check.read_result(layout) == HealthResult("stopped", "a user stopped it", since=check.since)
    assert systemd.calls == [RESTART, STOP], "nothing is started after the new release"


def test_reboot_keeps_the_check_pending(layout: Layout, systemd: ScriptedSystemd, check: HealthCheck) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, check.since).begin(layout)
    systemd.folder.joinpath("system").write_text("stopping\n")
    systemd.set_states(*LIVES, at.STOPPED)
    with pytest.raises(ShutdownError):
        health_check.run_check(layout)
    assert health_check.read_pending(layout) == HealthCheck(NEW, OLD, LONG, LONG, check.since)
    assert check.read_result(layout) is None


@pytest.mark.parametrize("verb", ["show", "restart"])
def test_lost_systemd_keeps_the_check_pending(
    layout: Layout, systemd: ScriptedSystemd, check: HealthCheck, verb: str
) -> None:
    systemd.set_states(*LIVES)
    systemd.fail(verb, at.LEFT)
    with pytest.raises(AgentError):
        health_check.run_check(layout)
    assert health_check.read_pending(layout) == check
    assert check.read_result(layout) is None


def test_missing_systemd_keeps_the_check_pending(
    layout: Layout, check: HealthCheck, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setenv("PATH", str(layout.root))
    with raises(AgentError, "no-systemd"):
        health_check.run_check(layout)
    assert health_check.read_pending(layout) == check
    assert check.read_result(layout) is None
    with raises(AgentError, "no-systemd"):
        robot_facts.require_lingering()


def test_refused_unit_makes_the_release_unhealthy(
    layout: Layout, systemd: ScriptedSystemd, check: HealthCheck, raises: Raises
) -> None:
    """The unit is broken, so the restart of the old release fails too, and the user gets the error."""
    systemd.set_states(*LIVES)
    systemd.fail("restart", at.UNKNOWN)
    with raises(AgentError, "systemctl"):
        health_check.run_check(layout)
    assert releases.read_current(layout) == OLD
    result = check.read_result(layout)
    assert result
    assert "Unit robotcore.service not found" in result.reason


def test_check_killed_after_its_result_is_completed(
    layout: Layout, systemd: ScriptedSystemd, check: HealthCheck
) -> None:
    make_current(layout, NEW)
    HealthResult("unhealthy", "it ended with status 1", (), check.since).write(layout.releases / NEW)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)
    assert systemd.calls == [STOP, RESTART], "only the old release is started"


def test_result_of_an_earlier_check_is_ignored(layout: Layout, systemd: ScriptedSystemd, check: HealthCheck) -> None:
    HealthResult("unhealthy", "it ended with status 1", (), "2026-11-20T10:00:00Z").write(layout.releases / NEW)
    systemd.set_states(*LIVES)
    health_check.run_check(layout)
    assert releases.read_current(layout) == NEW


@pytest.mark.slow
def test_failed_release_does_not_run_even_if_no_link_can_be_made(
    layout: Layout, systemd: ScriptedSystemd, check: HealthCheck
) -> None:
    HealthCheck(NEW, OLD, LONG, LONG, check.since).begin(layout)
    layout.releases.joinpath(NEW, "outcome.json").mkdir()
    in_the_way = layout.root / f".current.{os.getpid()}"
    systemd.set_states(*DIES)
    systemd.run_at(len(DIES), f'mkdir "{in_the_way}"')
    for _ in range(2):
        with pytest.raises(OSError, match=in_the_way.name):
            health_check.run_check(layout)
    assert systemd.calls == [START_CHECK, RESTART, STOP], "a repeated check starts nothing"
    in_the_way.rmdir()
    systemd.folder.joinpath(f"then.robotcore.service.{len(DIES)}").unlink()
    systemd.set_states(*DIES)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)


@pytest.mark.parametrize("known, stays", [("unhealthy", OLD), ("healthy", NEW)])
def test_stop_after_the_result_keeps_the_result(
    layout: Layout, systemd: ScriptedSystemd, check: HealthCheck, known: str, stays: str
) -> None:
    make_current(layout, NEW)
    (result := HealthResult(known, "it is known why", (), check.since)).write(layout.releases / NEW)
    health_check.abandon_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (stays, None)
    assert check.read_result(layout) == result
    assert RESTART not in systemd.calls


def test_missing_release_changes_nothing(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, current=OLD)
    HealthCheck(NEW, OLD, LONG, 0.0, "now").begin(layout)
    health_check.run_check(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"release": "../../etc", "previous": null}', '{"previous": null}'])
def test_invalid_file_is_no_pending_check(layout: Layout, text: str) -> None:
    layout.root.mkdir(parents=True)
    layout.health_check.write_text(text)
    assert health_check.read_pending(layout) is None


def test_check_that_systemd_refuses_is_not_pending(layout: Layout, systemd: ScriptedSystemd, raises: Raises) -> None:
    layout.root.mkdir(parents=True)
    systemd.fail("start", at.NO_BUS)
    with raises(AgentError, "manager", hide=[robot_facts.read_user(), os.getuid()]):
        HealthCheck(NEW, OLD).begin(layout)
    assert not layout.health_check.exists()


WORDS = ("Traceback (most recent call last):", "OSError: camera: no picture for 1 s. Look at its cable")


@pytest.mark.parametrize(
    "looks, result",
    [
        ((at.OLD_RUNS, at.OLD_STOPS, at.NEW_STARTS, at.NEW_RUNS), HealthResult("healthy")),
        ((at.OLD_WAITS, at.OLD_AGAIN, at.OLD_STOPS_AGAIN, at.NEW_STARTS, at.NEW_RUNS), HealthResult("healthy")),
        (
            (at.OLD_RUNS, at.OLD_RUNS, at.OLD_STOPS, at.NEW_STARTS, at.NEW_FAILS, at.NEW_WAITS),
            HealthResult("unhealthy", "it ended with status 1"),
        ),
        ((at.OLD_RUNS, at.AGAIN_RUNS), HealthResult("unhealthy", "it was started again")),
        ((at.OLD_RUNS, at.NEW_STARTS, at.SUCCEEDS, at.SUCCEEDED), HealthResult("healthy", "it ended with success")),
        ((at.PASSED_OVER,), HealthResult("unhealthy", "systemd did not start it")),
    ],
    ids=["runs", "previous restarts", "fails", "failed before the first query", "succeeds", "does not start"],
)
def test_result_is_that_of_the_new_release(
    systemd: ScriptedSystemd, looks: tuple[str, ...], result: HealthResult
) -> None:
    systemd.set_states(*looks)
    assert health_check.watch_app(LONG, 0.0) == result
    assert systemd.calls == ["restart --no-block robotcore.service"], "one job restarts the app"


@pytest.mark.parametrize("looks", [(at.NEW_RUNS, at.STOPPED), (at.NEW_RUNS, at.KILLED), (at.PASSED_OVER,)])
def test_shutdown_gives_no_result(systemd: ScriptedSystemd, looks: tuple[str, ...]) -> None:
    for system in ("stopping", "offline", ""):
        systemd.folder.joinpath("system").write_text(system)
        systemd.set_states(at.OLD_RUNS, *looks)
        with pytest.raises(health_check.ShutdownError):
            health_check.watch_app(LONG, LONG)


@pytest.mark.parametrize(
    "looks, reason",
    [
        ((at.NEW_RUNS, at.NEW_FAILS, at.NEW_WAITS), "it ended with status 1"),
        ((at.UNUSABLE,), "it ended with status 2 (it cannot run as it is described)"),
        ((at.NEW_RUNS, at.NEW_WAITS.replace(" 1 1 ", " 1 5 ")), "it ended with status 5 (the app raised, or hung)"),
        ((at.NEW_RUNS, at.KILLED), "it was ended by SIGKILL"),
        ((at.NEW_RUNS, at.HANGS, at.HUNG), "it hung: it did not reset systemd's watchdog"),
        ((at.TOO_SLOW, at.WAS_TOO_SLOW), "it took too long to start or to stop"),
        ((at.NEVER_READY, at.WAS_NEVER_READY), "it ended with status 0 before its first tick"),
        ((at.NEW_RUNS, at.BETWEEN, at.AGAIN_RUNS), "it was started again"),
    ],
)
def test_failed_release_is_unhealthy_with_its_last_lines(
    systemd: ScriptedSystemd, looks: tuple[str, ...], reason: str
) -> None:
    systemd.set_states(at.OLD_RUNS, at.NEW_STARTS, *looks)
    systemd.set_lines(*WORDS)
    assert health_check.watch_app(LONG, LONG) == HealthResult("unhealthy", reason, WORDS)
    assert "_SYSTEMD_INVOCATION_ID=0c7fb2b1ea3440b5ae86df6299644aee" in systemd.journal_arguments


def test_restart_by_a_user_begins_the_check_again(systemd: ScriptedSystemd) -> None:
    systemd.set_states(at.OLD_RUNS, at.NEW_RUNS, at.BETWEEN, at.BACK_STARTS, at.BACK_RUNS, at.BACK_FAILS)
    systemd.set_lines(*WORDS)
    assert health_check.watch_app(LONG, LONG) == HealthResult("unhealthy", "it ended with status 1", WORDS)
    assert "_SYSTEMD_INVOCATION_ID=e67fb2b1ea3440b5ae86df6299644aee" in systemd.journal_arguments
    systemd.set_states(at.OLD_RUNS, at.NEW_STARTS, at.BETWEEN, at.BACK_STARTS, at.BACK_RUNS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")


def test_release_is_not_healthy_before_it_resets_the_watchdog(
    systemd: ScriptedSystemd, monkeypatch: pytest.MonkeyPatch
) -> None:
    systemd.set_states(at.OLD_RUNS, at.NEW_STARTS, at.NEW_HANGS, at.NEW_HANGS, at.NEW_FAILS, at.NEW_WAITS)
    systemd.set_lines(*WORDS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("unhealthy", "it ended with status 1", WORDS)
    systemd.set_states(at.OLD_RUNS, at.NEW_HANGS, at.NEW_HANGS, at.NEW_RUNS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")
    monkeypatch.setattr(health_check, "NO_WATCHDOG_S", 0.0)  # a unit without a watchdog
    systemd.set_states(at.OLD_RUNS, at.NEW_HANGS)
    assert health_check.watch_app(LONG, 0.0) == HealthResult("healthy")


def test_last_lines_are_read_after_the_process_has_ended(systemd: ScriptedSystemd) -> None:
    systemd.set_states(at.OLD_RUNS, at.NEW_RUNS, at.HANGS, at.HUNG)
    systemd.set_lines("release 2026-11-21T22-40-01Z: search.py on raspberrypi")
    systemd.run_at(4, "echo 'Fatal Python error: Aborted' > journal")
    assert health_check.watch_app(LONG, LONG).lines == ("Fatal Python error: Aborted",)


def test_slow_release_is_unhealthy(systemd: ScriptedSystemd, check_text: CheckText) -> None:
    systemd.set_states(at.OLD_RUNS, at.NEW_STARTS)
    result = health_check.watch_app(0.0, LONG)
    assert (result.outcome, result.lines) == ("unhealthy", ())
    check_text(result.reason)

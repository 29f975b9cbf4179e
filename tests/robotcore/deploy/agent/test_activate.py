from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from robotcore.deploy.agent import files, health_check, releases, robot_facts, run_actions
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck
from robotcore.deploy.agent.releases import HealthResult
from robotcore.deploy.agent.rpc import MARK, AgentError
from robotcore.deploy.agent.units import HEALTH_CHECK, UNIT_TEXTS
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, NEWER, OLD, make_current, put_release
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd
from tests.texts import Raises

FAILED_TRIAL = "failed failed exit-code 9a 0 1 2 -"
FAILED_TO_START_AGAIN = "failed failed exit-code 0c 0 1 1 2140"
TRIAL_RUNS = "active running success 9a 0 0 0 -"

pytestmark = pytest.mark.usefixtures("lingering")


def conducts(layout: Layout, systemd: ScriptedSystemd, name: str, verdict: HealthResult, then_current: str) -> None:
    """Let systemd's trial of a release end with a verdict, at the second look at it."""
    result = {"outcome": verdict.outcome, "reason": verdict.reason, "lines": verdict.lines}
    since = shlex.quote('s/.*"since": "\\(.*\\)".*/\\1/p')
    root, release = shlex.quote(str(layout.root)), shlex.quote(str(layout.releases / name))
    systemd.will_tell(TRIAL_RUNS, TRIAL_RUNS, unit=HEALTH_CHECK)
    systemd.then(
        2,
        f"cd {root}; since=$(sed -n {since} trial.json)\n"
        f"printf '%s\\n' {shlex.quote(json.dumps(result)[:-1])}', \"since\": \"'$since'\"}}' > {release}/verdict.json\n"
        f"ln -sfn releases/{then_current} current; rm trial.json",
        unit=HEALTH_CHECK,
    )


def test_release_that_lives_is_reported_step_by_step(
    layout: Layout, systemd: ScriptedSystemd, capsys: pytest.CaptureFixture[str]
) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    put_release(layout, NEW)
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS)
    conducts(layout, systemd, NEW, HealthResult("healthy"), NEW)
    runs(layout, systemd, NEW)
    came = run_actions.activate_release(layout, release=NEW, settle_s=2)
    assert came == build_report(NEW, "healthy", current=NEW, is_running=True)
    assert said(capsys) == ["it starts", "it is ready; whether it stays so is seen for 2 s"]


def test_release_that_does_not_live_is_reported_with_what_runs_again(
    layout: Layout, systemd: ScriptedSystemd, capsys: pytest.CaptureFixture[str]
) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    put_release(layout, NEW)
    systemd.will_tell(at.OLD_RUNS, FAILED_TO_START_AGAIN, at.BACK_STARTS, at.BACK_RUNS)
    conducts(layout, systemd, NEW, HealthResult("unhealthy", "it ended with status 1", ("OSError",)), OLD)
    came = run_actions.activate_release(layout, release=NEW)
    assert came == build_report(
        NEW, "unhealthy", reason="it ended with status 1", lines=["OSError"], current=OLD, is_running=True
    )
    assert said(capsys) == [f"{OLD} runs again"]


def test_trial_is_written_down_and_the_robot_seen_to_before_anything_changes(
    layout: Layout, systemd: ScriptedSystemd, raises: Raises
) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    put_release(layout, NEW)
    systemd.will_tell(FAILED_TRIAL, unit=HEALTH_CHECK)
    with raises(AgentError, "check-failed"):
        run_actions.activate_release(layout, release=NEW, healthy_within_s=7, settle_s=2)
    tried = health_check.read_pending(layout)
    assert tried
    assert (tried.release, tried.previous, tried.healthy_within_s, tried.settle_s) == (NEW, OLD, 7, 2)
    assert {unit.name: unit.read_text() for unit in layout.units.iterdir()} == dict(UNIT_TEXTS)
    assert layout.program.exists()
    assert systemd.calls == [
        "daemon-reload",
        "enable robotcore.service robotcore-trial.service",
        "start --no-block robotcore-trial.service",
    ]
    assert releases.read_current(layout) == OLD, "the trial's own business"


def test_units_that_are_there_are_not_read_again(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    systemd.will_tell(FAILED_TRIAL, unit=HEALTH_CHECK)
    for _ in range(2):
        with pytest.raises(AgentError):
            run_actions.activate_release(layout, release=NEW)
        layout.health_check.unlink()
    assert systemd.calls.count("enable robotcore.service robotcore-trial.service") == 2
    assert systemd.calls.count("daemon-reload") == 1


def test_trial_that_is_under_way_is_looked_at_once_more(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    begun = HealthCheck(NEW, None, since="2026-11-21T22:40:03Z")
    begun.begin(layout)
    conducts(layout, systemd, NEW, HealthResult("healthy"), NEW)
    runs(layout, systemd, NEW)
    assert run_actions.activate_release(layout, release=NEW)["outcome"] == "healthy"
    assert begun.read_result(layout)


@pytest.mark.parametrize("outcome, in_place", [("healthy", NEW), ("unhealthy", OLD), ("stopped", OLD)])
def test_verdict_that_a_lost_connection_missed_is_reported(
    layout: Layout, systemd: ScriptedSystemd, outcome: str, in_place: str
) -> None:
    for name in (OLD, NEW):
        put_release(layout, name)
    make_current(layout, in_place)
    HealthResult(outcome, "why").write(layout.releases / NEW)
    assert run_actions.activate_release(layout, release=NEW) == build_report(
        NEW, outcome, reason="why", current=in_place
    )
    assert systemd.calls == []


def test_release_after_one_that_was_never_judged_goes_back_to_the_one_before_it(
    layout: Layout, systemd: ScriptedSystemd
) -> None:
    for name in (OLD, NEW, NEWER):
        put_release(layout, name)
    make_current(layout, NEW)
    HealthCheck(NEW, OLD, was_standing=True, was_enabled=False).begin(layout)
    systemd.will_tell(FAILED_TRIAL, unit=HEALTH_CHECK)
    with pytest.raises(AgentError):
        run_actions.activate_release(layout, release=NEWER)
    tried = health_check.read_pending(layout)
    assert tried
    assert (tried.release, tried.previous, tried.was_standing, tried.was_enabled) == (NEWER, OLD, True, False)


@pytest.fixture
def robot(layout: Layout) -> Layout:
    """A robot with an old release in place, which is healthy, and a new one beside it."""
    for name in (OLD, NEW):
        put_release(layout, name)
    HealthResult("healthy").write(layout.releases / OLD)
    make_current(layout, OLD)
    return layout


def begun(robot: Layout, systemd: ScriptedSystemd, release: str = NEW) -> dict[str, Any]:
    """Return what is on trial once a release is activated; it is over as soon as somebody looks."""
    systemd.then(1, f"mv {shlex.quote(str(robot.health_check))} ./was", unit=HEALTH_CHECK)
    run_actions.activate_release(robot, release=release)
    check: dict[str, Any] = json.loads(systemd.folder.joinpath("was").read_text())
    return check


@pytest.mark.parametrize(
    "looks, was_standing, was_enabled",
    [
        ([at.OLD_RUNS], False, True),
        ([at.OLD_WAITS], False, True),
        ([at.NEW_STARTS, at.UNUSABLE], False, True),
        ([at.RUNS_ONCE], False, False),
        ([at.PUT_OFF], True, False),
        ([at.GAVE_UP], True, True),
        ([at.UNUSABLE], True, True),
        ([at.SUCCEEDED], True, True),
        ([at.SUCCEEDS, at.SUCCEEDED], True, True),
        ([at.NEW_FAILS, at.UNUSABLE], True, True),
        ([at.NEW_FAILS, at.NEW_WAITS], False, True),
    ],
)
def test_release_before_is_to_run_again_only_where_it_ran(
    robot: Layout, systemd: ScriptedSystemd, looks: list[str], was_standing: bool, was_enabled: bool
) -> None:
    systemd.will_tell(*looks)
    check = begun(robot, systemd)
    assert (check["release"], check["previous"]) == (NEW, OLD)
    assert (check["was_standing"], check["was_enabled"]) == (was_standing, was_enabled)


def test_current_release_that_nothing_is_known_of_goes_back_to_the_healthy_one_before(
    robot: Layout, systemd: ScriptedSystemd
) -> None:
    make_current(robot, NEW)
    systemd.will_tell(at.OLD_RUNS)
    assert begun(robot, systemd)["previous"] == OLD


def test_trial_that_somebody_has_ended_is_not_looked_at_for_ever(
    robot: Layout, systemd: ScriptedSystemd, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(health_check, "ABANDONED_S", 0.0)
    with raises(AgentError, "check-stopped", release=NEW):
        run_actions.activate_release(robot, release=NEW)


def test_trial_that_broke_off_goes_on_with_a_start(robot: Layout, systemd: ScriptedSystemd) -> None:
    HealthCheck(NEW, OLD).begin(robot)
    systemd.then(1, f"rm {shlex.quote(str(robot.health_check))}", unit=HEALTH_CHECK)
    systemd.will_tell(at.NEW_RUNS)
    run_actions.start_app(robot)
    assert systemd.calls[-1] == "start --no-block robotcore-trial.service"


@pytest.mark.parametrize("within_s", [0.0, -1.0, 121.0, float("nan")])
def test_time_that_systemd_would_not_give_is_refused(layout: Layout, within_s: float, raises: Raises) -> None:
    put_release(layout, NEW)
    with raises(AgentError, "time-limit", limit_s=120):
        run_actions.activate_release(layout, release=NEW, healthy_within_s=within_s)


def test_release_that_is_not_there_is_refused(layout: Layout, raises: Raises) -> None:
    with raises(AgentError, "no-release"):
        run_actions.activate_release(layout, release=NEW)


def test_robot_whose_systemd_ends_with_the_connection_is_refused_and_nothing_changes(
    layout: Layout, systemd: ScriptedSystemd, lingering: Path, raises: Raises
) -> None:
    next(lingering.iterdir()).unlink()
    systemd.folder.joinpath("loginctl").write_text("#!/bin/sh\necho Access denied >&2; exit 1\n")
    systemd.folder.joinpath("loginctl").chmod(0o755)
    put_release(layout, NEW)
    with raises(AgentError, "linger", hide=[robot_facts.read_user()]):
        run_actions.activate_release(layout, release=NEW)
    assert systemd.calls == []
    assert not layout.health_check.exists()


def test_rollback_takes_the_last_healthy_release_before(layout: Layout, systemd: ScriptedSystemd) -> None:
    for name in (OLD, NEW, NEWER):
        put_release(layout, name)
    HealthResult("healthy").write(layout.releases / OLD)
    HealthResult("unhealthy", "it ended with status 1").write(layout.releases / NEW)
    make_current(layout, NEWER)
    conducts(layout, systemd, OLD, HealthResult("healthy"), OLD)
    assert run_actions.roll_back(layout)["release"] == OLD


def test_rollback_never_goes_on_to_a_newer_release(layout: Layout, systemd: ScriptedSystemd) -> None:
    for name in (OLD, NEW, NEWER):
        put_release(layout, name)
        HealthResult("healthy").write(layout.releases / name)
    make_current(layout, NEW)
    conducts(layout, systemd, OLD, HealthResult("healthy"), OLD)
    assert run_actions.roll_back(layout)["release"] == OLD


def test_rollback_to_a_named_release_tries_it_whatever_is_known_of_it(layout: Layout, systemd: ScriptedSystemd) -> None:
    for name in (OLD, NEW):
        put_release(layout, name)
    HealthResult("unhealthy", "it ended with status 1").write(layout.releases / OLD)
    make_current(layout, NEW)
    conducts(layout, systemd, OLD, HealthResult("healthy"), OLD)
    assert run_actions.roll_back(layout, release=OLD)["outcome"] == "healthy"
    assert "start --no-block robotcore-trial.service" in systemd.calls


def test_rollback_without_a_healthy_release_names_those_that_are_there(layout: Layout, raises: Raises) -> None:
    for name in (OLD, NEW):
        put_release(layout, name)
    make_current(layout, NEW)
    with raises(AgentError, "no-healthy-release", current=NEW, choices=[OLD]):
        run_actions.roll_back(layout)


def test_rollback_does_not_offer_what_did_not_live(layout: Layout, raises: Raises) -> None:
    HealthResult("unhealthy", "it ended with status 1").write(put_release(layout, OLD))
    with raises(AgentError, "no-healthy-release", current=None, choices=[]):
        run_actions.roll_back(layout)


def test_rollback_to_what_is_not_there_names_what_is(layout: Layout, raises: Raises) -> None:
    put_release(layout, OLD)
    with raises(AgentError, "name", choices=[OLD]):
        run_actions.roll_back(layout, release=NEW)


def test_rollback_to_what_is_in_place_is_refused(layout: Layout, raises: Raises) -> None:
    put_release(layout, NEW)
    make_current(layout, NEW)
    with raises(AgentError, "already-current"):
        run_actions.roll_back(layout, release=NEW)


@pytest.mark.parametrize("name", ["../../../etc", "current", "2026-11-21T22-40-00Z/../..", "$(reboot)"])
@pytest.mark.parametrize("act, kind", [(run_actions.activate_release, "release-name"), (run_actions.roll_back, "name")])
def test_name_that_is_none_is_refused_before_a_path_is_made_of_it(
    layout: Layout, act: Any, kind: str, name: str
) -> None:
    with pytest.raises(AgentError) as refused:
        act(layout, release=name)
    assert refused.value.kind == kind


def runs(layout: Layout, systemd: ScriptedSystemd, name: str) -> None:
    """Let it be noted that a release runs."""
    releases.find_running_link().parent.mkdir(parents=True)
    files.replace_link(releases.find_running_link(), str(layout.releases / name))


def build_report(release: str, outcome: str, **more: Any) -> dict[str, Any]:
    nothing: dict[str, Any] = {"reason": "", "lines": [], "current": None, "is_running": False}
    nothing["is_standing"] = not more.get("is_running")
    return {"release": release, "outcome": outcome, **nothing, **more}


def said(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [json.loads(line.removeprefix(MARK))["say"] for line in capsys.readouterr().out.split("\n")[:-1]]

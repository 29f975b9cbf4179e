from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from robotcore.deploy.agent import files, health_check, releases, robot_facts, run_actions
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck
from robotcore.deploy.agent.releases import HealthResult
from robotcore.deploy.agent.rpc import MARK
from robotcore.deploy.agent.systemd_units import HEALTH_CHECK, UNIT_TEXTS
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, NEWER, OLD, make_current, put_release, put_releases
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd
from tests.texts import Raises

FAILED_CHECK = "failed failed exit-code 9a 0 1 2 -"
FAILED_TO_START_AGAIN = "failed failed exit-code 0c 0 1 1 2140"
CHECK_RUNS = "active running success 9a 0 0 0 -"

pytestmark = pytest.mark.usefixtures("lingering")


def script_check(layout: Layout, systemd: ScriptedSystemd, name: str, result: HealthResult, current: str) -> None:
    """Script systemd so that the health check of a release ends with a result at the second query of its state."""
    fields = {"outcome": result.outcome, "reason": result.reason, "lines": result.lines}
    since = shlex.quote('s/.*"since": "\\(.*\\)".*/\\1/p')
    root, release = shlex.quote(str(layout.root)), shlex.quote(str(layout.releases / name))
    systemd.set_states(CHECK_RUNS, CHECK_RUNS, unit=HEALTH_CHECK)
    systemd.run_at(
        2,
        f"cd {root}; since=$(sed -n {since} health-check.json)\n"
        f"printf '%s\\n' {shlex.quote(json.dumps(fields)[:-1])}', \"since\": \"'$since'\"}}' > {release}/outcome.json\n"
        f"ln -sfn releases/{current} current; rm health-check.json",
        unit=HEALTH_CHECK,
    )


def test_progress_of_a_healthy_release_is_reported(
    layout: Layout, systemd: ScriptedSystemd, capsys: pytest.CaptureFixture[str]
) -> None:
    put_releases(layout, OLD, NEW, current=OLD)
    systemd.set_states(at.OLD_RUNS, at.NEW_STARTS, at.NEW_RUNS)
    script_check(layout, systemd, NEW, HealthResult("healthy"), NEW)
    mark_running(layout, NEW)
    report = run_actions.activate_release(layout, release=NEW)
    assert report == build_health_answer(NEW, "healthy", current=NEW, is_running=True)
    assert read_progress(capsys) == ["it starts", "it is ready, and must keep running for 4 s"]


def test_report_on_an_unhealthy_release_names_the_one_that_runs_again(
    layout: Layout, systemd: ScriptedSystemd, capsys: pytest.CaptureFixture[str]
) -> None:
    put_releases(layout, OLD, NEW, current=OLD)
    systemd.set_states(at.OLD_RUNS, FAILED_TO_START_AGAIN, at.BACK_STARTS, at.BACK_RUNS)
    script_check(layout, systemd, NEW, HealthResult("unhealthy", "it ended with status 1", ("OSError",)), OLD)
    report = run_actions.activate_release(layout, release=NEW)
    assert report == build_health_answer(
        NEW, "unhealthy", reason="it ended with status 1", lines=["OSError"], current=OLD, is_running=True
    )
    assert read_progress(capsys) == [f"{OLD} runs again"]


def test_check_and_units_are_written_before_the_current_release_changes(
    layout: Layout, systemd: ScriptedSystemd, raises: Raises
) -> None:
    put_releases(layout, OLD, NEW, current=OLD)
    systemd.set_states(FAILED_CHECK, unit=HEALTH_CHECK)
    with raises(AgentError, "check-failed"):
        run_actions.activate_release(layout, release=NEW, healthy_within_s=7)
    check = health_check.read_pending(layout)
    assert check
    assert (check.release, check.previous, check.healthy_within_s) == (NEW, OLD, 7)
    assert {unit.name: unit.read_text() for unit in layout.units.iterdir()} == dict(UNIT_TEXTS)
    assert layout.program.exists()
    assert systemd.calls == [
        "daemon-reload",
        "enable robotcore.service robotcore-health-check.service",
        "start --no-block robotcore-health-check.service",
    ]
    assert releases.read_current(layout) == OLD


def test_second_activation_follows_the_running_check(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    begun = HealthCheck(NEW, None, since="2026-11-21T22:40:03Z")
    begun.begin(layout)
    script_check(layout, systemd, NEW, HealthResult("healthy"), NEW)
    mark_running(layout, NEW)
    assert run_actions.activate_release(layout, release=NEW)["outcome"] == "healthy"
    assert begun.read_result(layout)


@pytest.mark.parametrize("outcome, in_place", [("healthy", NEW), ("unhealthy", OLD), ("stopped", OLD)])
def test_second_activation_returns_the_stored_result(
    layout: Layout, systemd: ScriptedSystemd, outcome: str, in_place: str
) -> None:
    put_releases(layout, OLD, NEW, current=in_place)
    HealthResult(outcome, "why").write(layout.releases / NEW)
    assert run_actions.activate_release(layout, release=NEW) == build_health_answer(
        NEW, outcome, reason="why", current=in_place
    )
    assert systemd.calls == []


def test_release_never_rolls_back_to_one_whose_check_is_not_complete(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, NEW, NEWER, current=NEW)
    HealthCheck(NEW, OLD, was_standing=True, was_enabled=False).begin(layout)
    systemd.set_states(FAILED_CHECK, unit=HEALTH_CHECK)
    with pytest.raises(AgentError):
        run_actions.activate_release(layout, release=NEWER)
    check = health_check.read_pending(layout)
    assert check
    assert (check.release, check.previous, check.was_standing, check.was_enabled) == (NEWER, OLD, True, False)


@pytest.fixture
def robot(layout: Layout) -> Layout:
    """A robot with a healthy current release and a new one."""
    for name in (OLD, NEW):
        put_release(layout, name)
    HealthResult("healthy").write(layout.releases / OLD)
    make_current(layout, OLD)
    return layout


def plan_check(robot: Layout, systemd: ScriptedSystemd, release: str = NEW) -> dict[str, Any]:
    """Activate a release, and return its health check, which ends at the first query of its state."""
    systemd.run_at(1, f"mv {shlex.quote(str(robot.health_check))} ./was", unit=HEALTH_CHECK)
    run_actions.activate_release(robot, release=release)
    check: dict[str, Any] = json.loads(systemd.folder.joinpath("was").read_text())
    return check


@pytest.mark.parametrize(
    "looks, was_standing, was_enabled",
    [
        ([at.OLD_RUNS], False, True),
        ([at.OLD_WAITS], False, True),
        ([at.NEW_STARTS, at.UNUSABLE], False, True),
        ([at.PUT_OFF], True, False),
        ([at.GAVE_UP], True, True),
        ([at.SUCCEEDS, at.SUCCEEDED], True, True),
        ([at.NEW_FAILS, at.UNUSABLE], True, True),
        ([at.NEW_FAILS, at.NEW_WAITS], False, True),
    ],
)
def test_check_stores_whether_the_previous_release_ran(
    robot: Layout, systemd: ScriptedSystemd, looks: list[str], was_standing: bool, was_enabled: bool
) -> None:
    systemd.set_states(*looks)
    check = plan_check(robot, systemd)
    assert (check["release"], check["previous"]) == (NEW, OLD)
    assert (check["was_standing"], check["was_enabled"]) == (was_standing, was_enabled)


def test_recheck_of_the_current_release_rolls_back_to_the_last_healthy_one(
    robot: Layout, systemd: ScriptedSystemd
) -> None:
    make_current(robot, NEW)
    systemd.set_states(at.OLD_RUNS)
    assert plan_check(robot, systemd)["previous"] == OLD


def test_check_without_a_process_is_an_error(
    robot: Layout, systemd: ScriptedSystemd, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(health_check, "ABANDONED_S", 0.0)
    with raises(AgentError, "check-stopped", release=NEW):
        run_actions.activate_release(robot, release=NEW)


def test_start_resumes_a_pending_check(robot: Layout, systemd: ScriptedSystemd) -> None:
    HealthCheck(NEW, OLD).begin(robot)
    systemd.run_at(1, f"rm {shlex.quote(str(robot.health_check))}", unit=HEALTH_CHECK)
    systemd.set_states(at.NEW_RUNS)
    run_actions.start_app(robot)
    assert systemd.calls[-1] == "start --no-block robotcore-health-check.service"


def test_impossible_time_limit_is_refused(layout: Layout, raises: Raises) -> None:
    put_release(layout, NEW)
    for within_s in (0.0, 121.0, float("nan")):
        with raises(AgentError, "time-limit", limit_s=120):
            run_actions.activate_release(layout, release=NEW, healthy_within_s=within_s)


def test_robot_without_lingering_is_refused_and_nothing_changes(
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


def test_rollback_chooses_the_last_healthy_release_before_the_current_one(
    layout: Layout, systemd: ScriptedSystemd
) -> None:
    outcomes = {OLD: "healthy", NEW: "unhealthy", NEWER: "healthy", "2026-12-01T00-00-00Z": "healthy"}
    for name, outcome in outcomes.items():
        HealthResult(outcome).write(put_release(layout, name))
    make_current(layout, NEWER)
    script_check(layout, systemd, OLD, HealthResult("healthy"), OLD)
    assert run_actions.roll_back(layout)["release"] == OLD


def test_rollback_checks_a_named_release_again(layout: Layout, systemd: ScriptedSystemd) -> None:
    for name in (OLD, NEW):
        put_release(layout, name)
    HealthResult("unhealthy", "it ended with status 1").write(layout.releases / OLD)
    make_current(layout, NEW)
    script_check(layout, systemd, OLD, HealthResult("healthy"), OLD)
    assert run_actions.roll_back(layout, release=OLD)["outcome"] == "healthy"
    assert "start --no-block robotcore-health-check.service" in systemd.calls


def test_rollback_without_a_healthy_release_names_the_others(layout: Layout, raises: Raises) -> None:
    put_releases(layout, OLD, NEW, current=NEW)
    with raises(AgentError, "no-healthy-release", current=NEW, choices=[OLD]):
        run_actions.roll_back(layout)
    HealthResult("unhealthy", "it ended with status 1").write(layout.releases / OLD)
    with raises(AgentError, "no-healthy-release", current=NEW, choices=[]):
        run_actions.roll_back(layout)


@pytest.mark.parametrize("name", [NEW, "../../../etc", "current", f"{OLD}/../.."])
@pytest.mark.parametrize("act", [run_actions.activate_release, run_actions.roll_back])
def test_unknown_release_is_refused_with_the_known_ones(layout: Layout, act: Any, name: str) -> None:
    put_release(layout, OLD)
    with pytest.raises(AgentError) as refused:
        act(layout, release=name)
    assert (refused.value.kind, refused.value.fields) == ("name", {"choices": [OLD]})


def test_rollback_to_the_current_release_is_refused(layout: Layout, raises: Raises) -> None:
    put_releases(layout, NEW, current=NEW)
    with raises(AgentError, "already-current"):
        run_actions.roll_back(layout, release=NEW)


def mark_running(layout: Layout, name: str) -> None:
    """Create the link that marks a release as running."""
    releases.find_running_link().parent.mkdir(parents=True)
    files.replace_link(releases.find_running_link(), str(layout.releases / name))


def build_health_answer(release: str, outcome: str, **more: Any) -> dict[str, Any]:
    nothing: dict[str, Any] = {"reason": "", "lines": [], "current": None, "is_running": False}
    nothing["is_stopped"] = not more.get("is_running")
    return {"release": release, "outcome": outcome, **nothing, **more}


def read_progress(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [json.loads(line.removeprefix(MARK))["text"] for line in capsys.readouterr().out.split("\n")[:-1]]

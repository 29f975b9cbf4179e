from __future__ import annotations

import os
import time

import pytest

from robotcore.deploy.agent import health_check, releases, robot_facts, run_actions, units
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck
from robotcore.deploy.agent.releases import HealthResult
from robotcore.deploy.agent.rpc import AgentError
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, make_current, put_release
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd
from tests.texts import Raises

pytestmark = pytest.mark.usefixtures("lingering")


@pytest.mark.parametrize(
    "look, state",
    [
        (at.NEW_RUNS, "running"),
        (at.NEW_STARTS, "starting"),
        (at.OLD_STOPS, "stopping"),
        (at.NEW_WAITS, "restarting"),
        (at.UNUSABLE, "failed"),
        (at.SUCCEEDED, "ended"),
        (at.STOPPED, "stopped"),
        (at.NEVER_WAS, "stopped"),
    ],
)
def test_state_is_reported_in_a_word(layout: Layout, systemd: ScriptedSystemd, look: str, state: str) -> None:
    systemd.will_tell(look)
    came = run_actions.read_status(layout)
    assert came["state"] == state
    assert came["words"] == ("" if state == "stopped" else "searching, 30 s"), "what stands may not be what spoke"


def test_what_runs_is_reported_with_what_it_says_of_itself(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    HealthResult("healthy").write(layout.releases / OLD)
    layout.recordings.mkdir()
    layout.recordings.joinpath("run.mcap").write_bytes(bytes(1000))
    layout.recordings.joinpath("full-disk.mcap").touch()
    systemd.will_tell(at.AGAIN_RUNS)
    came = run_actions.read_status(layout)
    assert came.pop("free_bytes") > 0
    assert came.pop("for_s") == pytest.approx(time.monotonic() - 69920.658494, abs=60)
    assert came == {
        "release": OLD,
        "verdict": "healthy",
        "on_trial": None,
        "last": None,
        "state": "running",
        "restarts": 1,
        "words": "searching, 30 s",
        "reason": "",
        "lines": [],
        "starts_with_robot": True,
        "lingers": True,
        "recordings": {"files": 1, "bytes": 1000},
    }


def test_failure_is_reported_with_the_apps_last_words(layout: Layout, systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.UNUSABLE)
    systemd.writes("\x1b[31mmy_robot.toml: no such motor\x1b[0m", "", "tab\tand \x07bell")
    came = run_actions.read_status(layout)
    assert came["reason"] == "it ended with status 2 (it cannot run as it is described)"
    assert came["lines"] == ["[31mmy_robot.toml: no such motor[0m", "tab and bell"], "nothing moves a terminal's cursor"
    assert came["for_s"] is None


@pytest.mark.parametrize(
    "how, status_, reason",
    [
        ("exited", "5", "it ended with status 5 (the app raised, or hung)"),
        ("killed", "6", "it was ended by SIGABRT"),
    ],
)
def test_what_was_started_again_is_reported_with_why(
    layout: Layout, systemd: ScriptedSystemd, how: str, status_: str, reason: str
) -> None:
    systemd.will_tell(at.AGAIN_RUNS)
    systemd.tells_of_the_last_end(
        f'{{"EXIT_CODE": "{how}", "EXIT_STATUS": "{status_}", "USER_INVOCATION_ID": "d077"}}\n'
    )
    systemd.writes("ValueError: on purpose")
    came = run_actions.read_status(layout)
    assert (came["state"], came["reason"], came["lines"]) == ("running", reason, ["ValueError: on purpose"])
    assert "_SYSTEMD_INVOCATION_ID=d077" in systemd.asked


def test_of_a_dump_of_pythons_the_apps_own_line_is_reported(layout: Layout, systemd: ScriptedSystemd) -> None:
    thread = [f'  File "threading.py", line {number} in run' for number in range(40)]
    frames = ['  File "search.py", line 31 in step', *(f'  File "click/core.py", line {n} in main' for n in range(40))]
    systemd.will_tell(at.HUNG)
    systemd.writes(
        "release 2026-11-21T22-40-01Z: search.py on raspberrypi",
        "Fatal Python error: Aborted",
        "",
        "Thread 0x00007fa63a1dc6c0 (most recent call first):",
        *thread,
        "",
        "Current thread 0x00007fa63ac38b80 (most recent call first):",
        *frames,
        "Extension modules: numpy.core._multiarray_umath (total: 1)",
        "robotcore: the motors may still turn",
    )
    assert run_actions.read_status(layout)["lines"] == [
        "release 2026-11-21T22-40-01Z: search.py on raspberrypi",
        "Fatal Python error: Aborted",
        "Current thread 0x00007fa63ac38b80 (most recent call first):",
        *frames[:5],
        "robotcore: the motors may still turn",
    ]


def test_app_whose_words_nobody_may_read_is_reported_with_the_remedy(layout: Layout, systemd: ScriptedSystemd) -> None:
    systemd.will_tell(at.UNUSABLE)
    systemd.folder.joinpath("unreadable").write_text("No journal files were opened due to insufficient permissions.\n")
    assert "sudo usermod -aG systemd-journal" in run_actions.read_status(layout)["lines"][0]


def test_release_that_did_not_live_is_reported_where_none_is_in_place(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    HealthResult("unhealthy", "it ended with status 5").write(put_release(layout, OLD))
    came = run_actions.read_status(layout)
    assert came["release"] is None
    assert came["last"] == {"name": OLD, "outcome": "unhealthy", "reason": "it ended with status 5"}


def test_release_on_trial_is_named(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    HealthCheck(NEW, None).begin(layout)
    came = run_actions.read_status(layout)
    assert (came["on_trial"], came["release"], came["verdict"]) == (NEW, None, None)


STOPS = ["stop robotcore.service robotcore-trial.service", "stop robotcore.service", "disable robotcore.service"]


def test_stopped_app_stays_so_after_a_reboot(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    units.install_units(layout)
    systemd.will_tell(at.STOPPED)
    came = run_actions.stop_app(layout)
    assert (came["release"], came["state"]) == (OLD, "stopped")
    assert systemd.calls[2:] == STOPS
    calls = systemd.folder.joinpath("calls").read_text().splitlines()
    assert calls[calls.index(STOPS[1]) + 1] == "reset-failed robotcore.service", "what was stopped has not failed"


def test_release_on_trial_is_taken_back_and_nothing_is_started(layout: Layout, systemd: ScriptedSystemd) -> None:
    for name in (OLD, NEW):
        put_release(layout, name)
    make_current(layout, NEW)
    begun = HealthCheck(NEW, OLD, since="2026-11-21T22:40:03Z")
    units.install_units(layout)
    begun.begin(layout)
    systemd.will_tell(at.STOPPED)
    run_actions.stop_app(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)
    assert begun.read_result(layout) == HealthResult("stopped", "a user stopped it", since=begun.since)
    assert not [call for call in systemd.calls[3:] if "start" in call]


def test_robot_that_nothing_was_put_on_stands_already(layout: Layout, systemd: ScriptedSystemd) -> None:
    assert run_actions.stop_app(layout)["release"] is None
    assert systemd.calls == []


def test_app_that_does_not_stop_is_reported_of(layout: Layout, systemd: ScriptedSystemd, raises: Raises) -> None:
    units.install_units(layout)
    systemd.fails("stop", at.NO_BUS)
    with raises(AgentError, "manager", hide=[robot_facts.read_user(), os.getuid()]):
        run_actions.stop_app(layout)


def test_started_app_starts_with_the_robot_too(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, OLD)
    make_current(layout, OLD)
    systemd.will_tell(at.BACK_STARTS, at.BACK_RUNS)
    assert run_actions.start_app(layout)["state"] == "running"
    assert systemd.calls == [
        "daemon-reload",
        "enable robotcore.service robotcore-trial.service",
        "start --no-block robotcore.service",
    ]


def test_robot_without_a_release_has_nothing_to_start(layout: Layout, raises: Raises) -> None:
    with raises(AgentError, "no-current-release"):
        run_actions.start_app(layout)


LINE = "2026-11-21T22:58:38+0000 rover robotcore[9244]: found it"


def test_what_the_app_wrote_is_passed_on_as_it_is(
    layout: Layout, systemd: ScriptedSystemd, capfd: pytest.CaptureFixture[str]
) -> None:
    systemd.writes(LINE)
    assert run_actions.print_log(layout, lines=7) == {}
    assert capfd.readouterr().out == f"{LINE}\n"
    assert systemd.asked == "--no-pager --quiet --output=short-iso --lines=7 --user-unit=robotcore.service\n"


def test_what_it_writes_from_now_on_is_followed(layout: Layout, systemd: ScriptedSystemd) -> None:
    run_actions.print_log(layout, follow=True)
    assert systemd.asked.endswith(" --follow\n")


def test_journal_that_nobody_may_read_is_refused_with_the_remedy(
    layout: Layout, systemd: ScriptedSystemd, raises: Raises
) -> None:
    systemd.folder.joinpath("unreadable").write_text("insufficient permissions\n")
    with raises(AgentError, "journal", hide=[robot_facts.read_user()]):
        run_actions.print_log(layout)

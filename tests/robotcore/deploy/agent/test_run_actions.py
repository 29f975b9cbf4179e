from __future__ import annotations

import time
from dataclasses import replace

import pytest

from robotcore.deploy.agent import health_check, releases, robot_facts, run_actions
from robotcore.deploy.agent import systemd_units as units
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck
from robotcore.deploy.agent.releases import MANIFEST, HealthResult, Release
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, put_release, put_releases
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
def test_status_names_the_state(layout: Layout, systemd: ScriptedSystemd, look: str, state: str) -> None:
    systemd.set_states(look)
    answer = run_actions.read_status(layout)
    assert answer["state"] == state
    assert answer["status_text"] == ("" if state == "stopped" else "searching, 30 s"), "another release may have set it"


def test_status_of_a_running_app(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, current=OLD)
    HealthResult("healthy").write(layout.releases / OLD)
    layout.recordings.mkdir()
    layout.recordings.joinpath("run.mcap").write_bytes(bytes(1000))
    layout.recordings.joinpath("full-disk.mcap").touch()
    systemd.set_states(at.AGAIN_RUNS)
    answer = run_actions.read_status(layout)
    assert answer.pop("free_bytes") > 0
    assert answer.pop("for_s") == pytest.approx(time.monotonic() - 69920.658494, abs=60)
    assert answer == {
        "release": OLD,
        "outcome": "healthy",
        "pending": None,
        "last": None,
        "state": "running",
        "restarts": 1,
        "status_text": "searching, 30 s",
        "view_port": None,
        "reason": "",
        "lines": [],
        "starts_with_robot": True,
        "lingers": True,
        "recordings": {"files": 1, "bytes": 1000},
    }


def test_status_has_the_port_of_the_live_page(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, current=OLD)
    systemd.set_states(at.AGAIN_RUNS)
    folder = layout.releases / OLD
    replace(Release.read(folder), view_port=8080).write(folder)
    assert run_actions.read_status(layout)["view_port"] == 8080
    (folder / MANIFEST).write_text("damaged")
    assert run_actions.read_status(layout)["view_port"] is None


def test_status_has_the_last_lines_of_a_failed_app(layout: Layout, systemd: ScriptedSystemd) -> None:
    systemd.set_states(at.UNUSABLE)
    systemd.set_lines("\x1b[31mmy_robot.toml: no such motor\x1b[0m", "", "tab\tand \x07bell")
    answer = run_actions.read_status(layout)
    assert answer["reason"] == "it ended with status 2 (it cannot run as it is described)"
    assert answer["lines"] == ["[31mmy_robot.toml: no such motor[0m", "tab and bell"], "control characters are removed"
    assert answer["for_s"] is None


def test_status_has_the_reason_of_a_restart(layout: Layout, systemd: ScriptedSystemd) -> None:
    systemd.set_states(at.AGAIN_RUNS)
    systemd.set_last_end('{"EXIT_CODE": "killed", "EXIT_STATUS": "6", "USER_INVOCATION_ID": "d077"}\n')
    systemd.set_lines("ValueError: on purpose")
    answer = run_actions.read_status(layout)
    assert answer["state"] == "running"
    assert (answer["reason"], answer["lines"]) == ("it was ended by SIGABRT", ["ValueError: on purpose"])
    assert "_SYSTEMD_INVOCATION_ID=d077" in systemd.journal_arguments


def test_dump_of_an_aborted_python_is_shortened(layout: Layout, systemd: ScriptedSystemd) -> None:
    thread = [f'  File "threading.py", line {number} in run' for number in range(40)]
    frames = ['  File "search.py", line 31 in step', *(f'  File "click/core.py", line {n} in main' for n in range(40))]
    systemd.set_states(at.HUNG)
    systemd.set_lines(
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


def test_status_names_the_last_check_if_no_release_is_current(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_release(layout, NEW)
    HealthResult("unhealthy", "it ended with status 5").write(put_release(layout, OLD))
    HealthCheck(NEW, None).begin(layout)
    answer = run_actions.read_status(layout)
    assert (answer["pending"], answer["release"], answer["outcome"]) == (NEW, None, None)
    assert answer["last"] == {"name": OLD, "outcome": "unhealthy", "reason": "it ended with status 5"}


STOPS = ["stop robotcore.service robotcore-health-check.service", "stop robotcore.service", "disable robotcore.service"]


def test_stopped_app_stays_stopped_after_a_reboot(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, current=OLD)
    units.install_units(layout)
    systemd.set_states(at.STOPPED)
    answer = run_actions.stop_app(layout)
    assert (answer["release"], answer["state"]) == (OLD, "stopped")
    assert systemd.calls[2:] == STOPS
    calls = systemd.folder.joinpath("calls").read_text().splitlines()
    assert calls[calls.index(STOPS[1]) + 1] == "reset-failed robotcore.service", "a stop is no failure"


def test_stop_during_a_check_rolls_back_and_starts_nothing(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, NEW, current=NEW)
    check = HealthCheck(NEW, OLD, since="2026-11-21T22:40:03Z")
    units.install_units(layout)
    check.begin(layout)
    systemd.set_states(at.STOPPED)
    run_actions.stop_app(layout)
    assert (releases.read_current(layout), health_check.read_pending(layout)) == (OLD, None)
    assert check.read_result(layout) == HealthResult("stopped", "a user stopped it", since=check.since)
    assert not [call for call in systemd.calls[3:] if "start" in call]


def test_stop_of_an_empty_robot_does_nothing(layout: Layout, systemd: ScriptedSystemd) -> None:
    assert run_actions.stop_app(layout)["release"] is None
    assert systemd.calls == []


def test_start_enables_the_app_for_each_boot(layout: Layout, systemd: ScriptedSystemd) -> None:
    put_releases(layout, OLD, current=OLD)
    systemd.set_states(at.BACK_STARTS, at.BACK_RUNS)
    assert run_actions.start_app(layout)["state"] == "running"
    assert systemd.calls == [
        "daemon-reload",
        "enable robotcore.service robotcore-health-check.service",
        "start --no-block robotcore.service",
    ]


def test_start_without_a_release_is_refused(layout: Layout, raises: Raises) -> None:
    with raises(AgentError, "no-current-release"):
        run_actions.start_app(layout)


LINE = "2026-11-21T22:58:38+0000 rover robotcore[9244]: found it"


def test_log_is_printed_unchanged(layout: Layout, systemd: ScriptedSystemd, capfd: pytest.CaptureFixture[str]) -> None:
    systemd.set_lines(LINE)
    assert run_actions.print_log(layout, lines=7) == {}
    assert capfd.readouterr().out == f"{LINE}\n"
    assert (
        systemd.journal_arguments == "--no-pager --quiet --output=short-iso --lines=7 --user-unit=robotcore.service\n"
    )
    run_actions.print_log(layout, follow=True)
    assert systemd.journal_arguments.endswith(" --follow\n")


def test_log_of_an_unreadable_journal_is_refused(layout: Layout, systemd: ScriptedSystemd, raises: Raises) -> None:
    systemd.folder.joinpath("unreadable").write_text("insufficient permissions\n")
    with raises(AgentError, "journal", hide=[robot_facts.read_user()]):
        run_actions.print_log(layout)
    systemd.set_states(at.UNUSABLE)
    assert "sudo usermod -aG systemd-journal" in run_actions.read_status(layout)["lines"][0]

from __future__ import annotations

import time

import pytest

from robotcore.deploy.agent.actions import status
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.trial.trial import Trial
from tests.robotcore.deploy.agent import recorded as at
from tests.robotcore.deploy.agent.released import NEW, OLD, let_run, put
from tests.robotcore.deploy.agent.scripted import Scripted

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
def test_state_is_told_in_a_word(layout: Layout, systemd: Scripted, look: str, state: str) -> None:
    systemd.will_tell(look)
    came = status.act(layout)
    assert came["state"] == state
    assert came["words"] == ("" if state == "stopped" else "searching, 30 s"), "what stands may not be what spoke"


def test_what_runs_is_told_with_what_it_says_of_itself(layout: Layout, systemd: Scripted) -> None:
    put(layout, OLD)
    let_run(layout, OLD)
    Verdict("healthy").write(layout.releases / OLD)
    layout.recordings.mkdir()
    layout.recordings.joinpath("run.mcap").write_bytes(bytes(1000))
    layout.recordings.joinpath("full-disk.mcap").touch()
    systemd.will_tell(at.AGAIN_RUNS)
    came = status.act(layout)
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


def test_failure_is_told_with_the_apps_last_words(layout: Layout, systemd: Scripted) -> None:
    systemd.will_tell(at.UNUSABLE)
    systemd.writes("\x1b[31mmy_robot.toml: no such motor\x1b[0m", "", "tab\tand \x07bell")
    came = status.act(layout)
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
def test_what_was_started_again_is_told_with_why(
    layout: Layout, systemd: Scripted, how: str, status_: str, reason: str
) -> None:
    systemd.will_tell(at.AGAIN_RUNS)
    systemd.tells_of_the_last_end(
        f'{{"EXIT_CODE": "{how}", "EXIT_STATUS": "{status_}", "USER_INVOCATION_ID": "d077"}}\n'
    )
    systemd.writes("ValueError: on purpose")
    came = status.act(layout)
    assert (came["state"], came["reason"], came["lines"]) == ("running", reason, ["ValueError: on purpose"])
    assert "_SYSTEMD_INVOCATION_ID=d077" in systemd.asked


def test_of_a_dump_of_pythons_the_apps_own_line_is_told(layout: Layout, systemd: Scripted) -> None:
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
    assert status.act(layout)["lines"] == [
        "release 2026-11-21T22-40-01Z: search.py on raspberrypi",
        "Fatal Python error: Aborted",
        "Current thread 0x00007fa63ac38b80 (most recent call first):",
        *frames[:5],
        "robotcore: the motors may still turn",
    ]


def test_app_whose_words_nobody_may_read_is_told_with_the_remedy(layout: Layout, systemd: Scripted) -> None:
    systemd.will_tell(at.UNUSABLE)
    systemd.folder.joinpath("unreadable").write_text("No journal files were opened due to insufficient permissions.\n")
    assert "sudo usermod -aG systemd-journal" in status.act(layout)["lines"][0]


def test_release_that_did_not_live_is_told_where_none_is_in_place(layout: Layout, systemd: Scripted) -> None:
    put(layout, NEW)
    Verdict("unhealthy", "it ended with status 5").write(put(layout, OLD))
    came = status.act(layout)
    assert came["release"] is None
    assert came["last"] == {"name": OLD, "outcome": "unhealthy", "reason": "it ended with status 5"}


def test_release_on_trial_is_named(layout: Layout, systemd: Scripted) -> None:
    put(layout, NEW)
    Trial(NEW, None).begin(layout)
    came = status.act(layout)
    assert (came["on_trial"], came["release"], came["verdict"]) == (NEW, None, None)

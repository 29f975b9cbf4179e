from __future__ import annotations

import pytest

from robotcore.deploy.agent.telling import RefusalError
from robotcore.deploy.agent.trial import watching
from robotcore.deploy.agent.trial.watching import Seen
from tests.robotcore.deploy.agent import recorded as at
from tests.robotcore.deploy.agent.scripted import Scripted

LONG = 1000.0
WORDS = ("Traceback (most recent call last):", "OSError: camera: no picture for 1 s. Look at its cable")


def test_release_that_came_up_and_stayed_is_healthy(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.OLD_STOPS, at.NEW_STARTS, at.NEW_RUNS)
    assert watching.watch(LONG, 0.0) == Seen("healthy")
    assert systemd.calls == ["restart --no-block robotcore.service"], "one job: never neither"


def test_release_that_runs_already_is_not_taken_for_the_new_one(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.OLD_RUNS, at.OLD_STOPS, at.NEW_STARTS, at.NEW_FAILS, at.NEW_WAITS)
    assert watching.watch(LONG, 0.0).outcome == "unhealthy"


def test_release_before_that_fails_and_is_just_started_again_is_not_taken_for_the_new_one(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_WAITS, at.OLD_AGAIN, at.OLD_STOPS_AGAIN, at.NEW_STARTS, at.NEW_RUNS)
    assert watching.watch(LONG, 0.0) == Seen("healthy")


@pytest.mark.parametrize(
    "looks, reason",
    [
        ((at.NEW_FAILS, at.NEW_WAITS), "it ended with status 1"),
        ((at.NEW_RUNS, at.NEW_FAILS, at.NEW_WAITS), "it ended with status 1"),
        ((at.UNUSABLE,), "it ended with status 2 (it cannot run as it is described)"),
        ((at.NEW_RUNS, at.NEW_WAITS.replace(" 1 1 ", " 1 5 ")), "it ended with status 5 (the app raised, or hung)"),
        ((at.NEW_RUNS, at.KILLED), "it was ended by SIGKILL"),
        ((at.NEW_RUNS, at.HANGS, at.HUNG), "it hung: it told nothing to systemd's watchdog"),
        ((at.TOO_SLOW, at.WAS_TOO_SLOW), "it took too long to start or to stop"),
        ((at.NEVER_READY, at.WAS_NEVER_READY), "it ended with status 0 before its first step"),
        ((at.AGAIN_RUNS,), "it was started again"),
        ((at.NEW_RUNS, at.AGAIN_RUNS), "it was started again"),
        ((at.NEW_RUNS, at.BETWEEN, at.AGAIN_RUNS), "it was started again"),
    ],
)
def test_release_that_fails_is_unhealthy_and_told_of_in_its_own_words(
    systemd: Scripted, looks: tuple[str, ...], reason: str
) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, *looks)
    systemd.writes(*WORDS)
    assert watching.watch(LONG, LONG) == Seen("unhealthy", reason, WORDS)
    assert "_SYSTEMD_INVOCATION_ID=0c7fb2b1ea3440b5ae86df6299644aee" in systemd.asked


def test_release_that_somebody_restarts_is_watched_from_there_on(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.BETWEEN, at.BACK_STARTS, at.BACK_RUNS, at.BACK_FAILS)
    systemd.writes(*WORDS)
    assert watching.watch(LONG, LONG) == Seen("unhealthy", "it ended with status 1", WORDS)
    assert "_SYSTEMD_INVOCATION_ID=e67fb2b1ea3440b5ae86df6299644aee" in systemd.asked
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, at.BETWEEN, at.BACK_STARTS, at.BACK_RUNS)
    assert watching.watch(LONG, 0.0) == Seen("healthy")


def test_start_that_failed_before_anybody_looked_is_not_missed(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.AGAIN_RUNS)
    assert watching.watch(LONG, 0.0).outcome == "unhealthy"


def test_release_that_hangs_is_not_healthy_before_it_tells_that_it_is_alive(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS, at.NEW_HANGS, at.NEW_HANGS, at.NEW_FAILS, at.NEW_WAITS)
    systemd.writes(*WORDS)
    assert watching.watch(LONG, 0.0) == Seen("unhealthy", "it ended with status 1", WORDS)
    systemd.will_tell(at.OLD_RUNS, at.NEW_HANGS, at.NEW_HANGS, at.NEW_RUNS)
    assert watching.watch(LONG, 0.0) == Seen("healthy")


def test_release_whose_watchdog_somebody_switched_off_is_healthy_in_the_end(
    systemd: Scripted, monkeypatch: pytest.MonkeyPatch
) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_HANGS)
    monkeypatch.setattr(watching, "UNWATCHED_S", 0.0)
    assert watching.watch(LONG, 0.0) == Seen("healthy")


def test_last_words_are_those_of_a_process_that_has_ended(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.HANGS, at.HUNG)
    systemd.writes("release 2026-11-21T22-40-01Z: search.py on raspberrypi")
    systemd.then(4, "echo 'Fatal Python error: Aborted' > journal")
    assert watching.watch(LONG, LONG).lines == ("Fatal Python error: Aborted",)


def test_release_that_is_not_ready_in_time_is_unhealthy(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_STARTS)
    assert watching.watch(0.0, LONG) == Seen(
        "unhealthy",
        "its first step had not come back within 0 s; if it is only slow, push it with a longer --healthy-within",
    )


@pytest.mark.parametrize("within_s", [LONG, 0.0])
def test_release_that_ends_with_success_is_healthy_whenever_it_does(systemd: Scripted, within_s: float) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.SUCCEEDS, at.SUCCEEDED)
    assert watching.watch(within_s, LONG) == Seen("healthy", "it ended with success")


def test_release_that_somebody_stops_is_not_judged(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS, at.NEW_RUNS, at.STOPPED)
    assert watching.watch(LONG, LONG) == Seen("stopped", "somebody stopped it")


@pytest.mark.parametrize("system", ["stopping", "offline", ""])
@pytest.mark.parametrize("looks", [(at.NEW_RUNS, at.STOPPED), (at.NEW_RUNS, at.KILLED), (at.PASSED_OVER,)])
def test_release_that_ends_with_the_robot_is_not_judged_at_all(
    systemd: Scripted, system: str, looks: tuple[str, ...]
) -> None:
    systemd.folder.joinpath("system").write_text(system)
    systemd.will_tell(at.OLD_RUNS, *looks)
    with pytest.raises(watching.LeavingError):
        watching.watch(LONG, LONG)


def test_what_systemd_passes_over_is_unhealthy_at_once(systemd: Scripted) -> None:
    systemd.will_tell(at.PASSED_OVER)
    assert watching.watch(LONG, LONG) == Seen("unhealthy", "systemd did not start it")


def test_systemd_that_leaves_is_no_verdict(systemd: Scripted) -> None:
    systemd.will_tell(at.OLD_RUNS)
    systemd.fails("restart", at.LEFT)
    with pytest.raises(RefusalError, match="not connected") as refused:
        watching.watch(LONG, LONG)
    assert refused.value.kind == "manager"

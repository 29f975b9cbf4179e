"""Runs in processes that are killed, suspended or forked. Only another process can stop their motors."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
from collections.abc import Sequence

import pytest

from robotcore.runtime.signals import END_SIGNALS
from tests.robotcore.safety.guardian.doubles import MOTORS, Running, Start
from tests.robotcore.safety.guardian.recorder import notes
from tests.texts import CheckText


def on_each(action: str, motors: Sequence[str] = MOTORS) -> set[str]:
    return {f"{action} {motor}" for motor in motors}


def assert_stopped(running: Running) -> None:
    """Check that every cutoff stopped after the last command to a motor."""
    actions = running.actions
    last = max(at for at, action in enumerate(actions) if action.startswith("turn"))
    assert on_each("stop") <= set(actions[last:])
    assert set(actions[-len(MOTORS) :]) == on_each("close")


@pytest.mark.slow
def test_the_motors_of_a_killed_app_are_stopped(start: Start, check_text: CheckText) -> None:
    running = start("drives")
    running.process.kill()
    _, err = running.end()
    assert_stopped(running)
    check_text(err, hide=[running.process.pid])


@pytest.mark.slow
def test_a_fork_that_returns_from_step_ends_and_commands_no_motor(start: Start, check_text: CheckText) -> None:
    running = start("forks_and_returns")
    out, err = running.end()
    (copy,) = (note.process for note in notes(running.diary) if note.action == "copied")
    assert [note.action for note in notes(running.diary) if note.process == copy] == ["copied"]
    assert len(out.splitlines()) == 1
    assert json.loads(out)["outcome"] == "success"
    check_text(err, hide=[copy, running.process.pid])


@pytest.mark.slow
def test_a_tracer_that_keeps_the_watchdog_from_ending_a_run_is_reported(start: Start, check_text: CheckText) -> None:
    running = start("is_traced_and_hangs")
    out, err = running.end()
    result = json.loads(out)
    assert result["outcome"] == "success"
    check_text(re.sub(r"within [\d.]+ s, (.*), at .*?:\d+", r"within … s, \1, at …", result["notes"][0]))
    assert result["notes"][0] in err


@pytest.mark.slow
@pytest.mark.parametrize("app, status", [("crashes", -signal.SIGABRT), ("exits", 0)])
def test_the_motors_of_an_app_that_ends_its_own_process_are_stopped(
    start: Start, app: str, status: int, check_text: CheckText
) -> None:
    running = start(app)
    _, err = running.end()
    assert running.process.returncode == status
    assert_stopped(running)
    check_text(err, hide=[running.process.pid])


@pytest.mark.slow
def test_fork_of_the_app_does_not_hide_the_death_of_the_app(start: Start, check_text: CheckText) -> None:
    running = start("forks")
    wait_for(running, "copied")
    running.process.kill()
    running.process.wait()
    assert running.process.stderr
    check_text(running.process.stderr.readline(), hide=[running.process.pid])  # the fork lives on
    running.end()
    assert_stopped(running)


@pytest.mark.slow
@pytest.mark.parametrize("number", END_SIGNALS[:3])
def test_the_guardian_outlives_the_run_at_a_signal_to_all_processes_of_the_terminal(
    start: Start, number: signal.Signals
) -> None:
    running = start("drives")
    os.killpg(running.process.pid, number)
    result = running.read_result()
    assert (result["outcome"], running.process.returncode) == ("interrupted", 128 + number)
    assert not on_each("stop") & set(running.actions)
    assert set(running.actions[-len(MOTORS) :]) == on_each("close")


@pytest.mark.slow
def test_the_guardian_ignores_signals_that_ask_it_to_end(start: Start) -> None:
    running = start("drives")
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT):
        os.kill(running.guardian, number)
    running.process.kill()
    running.end()
    assert_stopped(running)


@pytest.mark.slow
def test_motors_stop_during_a_call_that_holds_the_interpreter_lock_and_drive_again_after_it(start: Start) -> None:
    running = start("holds")
    result = running.read_result()
    assert result["outcome"] == "success"
    assert result["causes"].count("guardian") == 2
    actions = running.actions
    begins, ends = ([at for at, each in enumerate(actions) if each == what] for what in ("hold", "release"))
    for begin, end in zip(begins, ends, strict=True):
        assert on_each("stop") <= set(actions[begin:end])
        assert on_each("turn", MOTORS[:2]) | on_each("arm") <= set(actions[end:])


@pytest.mark.slow
def test_the_motors_of_a_suspended_app_are_stopped_also_outside_the_drive(start: Start) -> None:
    running = start("grips")
    wait_for(running, "turn gripper")
    os.killpg(running.process.pid, signal.SIGSTOP)  # as Ctrl-Z does: the process lives but sends nothing
    wait_for(running, "stop gripper")
    os.killpg(running.process.pid, signal.SIGCONT)
    running.process.terminate()
    assert running.read_result()["outcome"] == "interrupted"


@pytest.mark.slow
def test_guardian_does_not_stop_a_robot_at_rest(start: Start) -> None:
    running = start("rests")
    wait_for(running, "stand right_motor", times=2)
    running.process.send_signal(signal.SIGSTOP)
    with pytest.raises(subprocess.TimeoutExpired):
        running.process.wait(0.5)  # some leases
    running.process.send_signal(signal.SIGCONT)
    running.process.terminate()
    assert running.read_result()["outcome"] == "interrupted"
    assert not on_each("stop") & set(running.actions)


@pytest.mark.slow
def test_guardian_ends_with_its_run(start: Start) -> None:
    running = start("ends")
    assert running.read_result()["outcome"] == "success"
    assert not on_each("stop") & set(running.actions)
    with pytest.raises(ProcessLookupError):
        os.kill(running.guardian, 0)


@pytest.mark.slow
def test_a_killed_guardian_ends_the_run(start: Start, check_text: CheckText) -> None:
    running = start("drives")
    os.kill(running.guardian, signal.SIGKILL)
    result = running.read_result()
    assert (result["outcome"], running.process.returncode) == ("error", 3)
    how = signal.strsignal(signal.SIGKILL)
    check_text(result["reason"], hide=[running.guardian, how])
    assert running.actions[-1].startswith("stand")


@pytest.mark.slow
def test_a_guardian_that_does_not_answer_ends_the_run(start: Start, check_text: CheckText) -> None:
    running = start("drives")
    os.kill(running.guardian, signal.SIGSTOP)
    result = running.read_result()
    assert running.process.returncode == 3
    check_text(re.sub(r"2\.\d s", "2.… s", result["reason"]), hide=[running.guardian])


@pytest.mark.slow
def test_the_guardian_stops_the_motors_if_a_drivers_stop_hangs(start: Start, check_text: CheckText) -> None:
    running = start("sticks")
    _, err = running.end()
    assert running.process.returncode == 3
    check_text(err, hide=[running.process.pid])
    assert_stopped(running)


@pytest.mark.slow
def test_a_cutoff_that_cannot_stop_ends_the_run_with_an_error(start: Start, check_text: CheckText) -> None:
    running = start("holds", "fails to stop")
    out, _ = running.end()
    assert running.process.returncode == 3
    check_text(json.loads(out)["reason"], hide=[running.guardian])


@pytest.mark.slow
def test_a_cutoff_that_cannot_stop_a_killed_app_is_reported_on_stderr(start: Start, check_text: CheckText) -> None:
    running = start("drives", "fails to stop")
    running.process.kill()
    _, err = running.end()
    check_text(err, hide=[running.process.pid])


@pytest.mark.slow
def test_a_cutoff_that_cannot_stop_a_suspended_app_is_reported_at_once(start: Start, check_text: CheckText) -> None:
    running = start("drives", "fails to stop")
    running.process.send_signal(signal.SIGSTOP)
    assert running.process.stderr
    check_text(running.process.stderr.readline())
    running.process.kill()
    running.end()


def wait_for(running: Running, action: str, times: int = 1) -> None:
    """Wait until the diary contains an action ``times`` times. Only the time limit of the test ends the wait."""
    while running.actions.count(action) < times:
        with pytest.raises(subprocess.TimeoutExpired):
            running.process.wait(0.01)

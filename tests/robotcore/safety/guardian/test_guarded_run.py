"""Runs in processes of their own, to which happens what no thread of theirs could do anything about."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Sequence

import pytest

from tests.robotcore.safety.guardian.doubles import MOTORS, Running, Start
from tests.robotcore.safety.guardian.recorder import notes


def of(deed: str, motors: Sequence[str] = MOTORS) -> set[str]:
    return {f"{deed} {motor}" for motor in motors}


def assert_stopped(running: Running) -> None:
    """Every cutoff was asked to stop after whatever the motors were told."""
    deeds = running.deeds
    last = max(at for at, deed in enumerate(deeds) if deed.startswith("turn"))
    assert of("stop") <= set(deeds[last:])
    assert set(deeds[-len(MOTORS) :]) == of("close")


def test_an_app_that_is_killed_has_its_motors_stopped(start: Start) -> None:
    running = start("drives")
    running.process.kill()
    _, err = running.end()
    assert_stopped(running)
    assert err == f"guardian: the run of process {running.process.pid} broke off; stopped {', '.join(MOTORS)}\n"


def test_a_copy_that_comes_back_from_step_ends_and_tells_the_motors_nothing(start: Start) -> None:
    running = start("forks_and_returns")
    out, err = running.end()
    (copy,) = (note.process for note in notes(running.diary) if note.what == "copied")
    assert [note.what for note in notes(running.diary) if note.process == copy] == ["copied"]
    assert len(out.splitlines()) == 1
    assert json.loads(out)["outcome"] == "success"
    assert f"process {copy}" in err


def test_a_tracer_that_keeps_the_watchdog_from_ending_a_run_is_named(start: Start) -> None:
    running = start("is_traced_and_hangs")
    out, err = running.end()
    result = json.loads(out)
    assert result["outcome"] == "success"
    assert "tracer" in result["notes"][0]
    assert result["notes"][0] in err


@pytest.mark.parametrize("app, status", [("crashes", -signal.SIGABRT), ("exits", 0)])
def test_an_app_that_ends_its_own_process_has_its_motors_stopped(start: Start, app: str, status: int) -> None:
    running = start(app)
    _, err = running.end()
    assert running.process.returncode == status
    assert_stopped(running)
    assert "broke off" in err


def test_a_copy_that_an_app_has_made_of_its_process_does_not_hide_its_end(start: Start) -> None:
    running = start("forks")
    until(running, "copied")
    running.process.kill()
    running.process.wait()
    assert running.process.stderr
    assert "broke off" in running.process.stderr.readline()  # the copy lives on
    running.end()
    assert_stopped(running)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_to_all_processes_of_the_terminal_leaves_the_guardian_until_the_run_has_ended(
    start: Start, number: signal.Signals
) -> None:
    running = start("drives")
    os.killpg(running.process.pid, number)
    result = running.read_result()
    assert (result["outcome"], running.process.returncode) == ("interrupted", 128 + number)
    assert not of("stop") & set(running.deeds)
    assert set(running.deeds[-len(MOTORS) :]) == of("close")


def test_the_guardian_does_not_end_by_a_signal_that_asks_for_it(start: Start) -> None:
    running = start("drives")
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT):
        os.kill(running.guardian, number)
    running.process.kill()
    running.end()
    assert_stopped(running)


def test_a_call_that_holds_the_interpreter_lock_is_not_waited_for_and_driving_goes_on_after_it(start: Start) -> None:
    running = start("holds")
    result = running.read_result()
    assert result["outcome"] == "success"
    assert result["causes"].count("guardian") == 2
    deeds = running.deeds
    begins, ends = ([at for at, each in enumerate(deeds) if each == what] for what in ("hold", "let go"))
    for begin, end in zip(begins, ends, strict=True):
        assert of("stop") <= set(deeds[begin:end])
        assert of("turn", MOTORS[:2]) | of("arm") <= set(deeds[end:])


def test_an_app_that_is_suspended_has_its_motors_stopped_also_one_outside_the_drive(start: Start) -> None:
    running = start("grips")
    until(running, "turn gripper")
    os.killpg(running.process.pid, signal.SIGSTOP)  # as Ctrl-Z does: it sends nothing, and it has not gone
    until(running, "stop gripper")
    os.killpg(running.process.pid, signal.SIGCONT)
    running.process.terminate()
    assert running.read_result()["outcome"] == "interrupted"


def test_a_robot_at_rest_is_left_at_rest(start: Start) -> None:
    running = start("rests")
    until(running, "stand right_motor", times=2)
    running.process.send_signal(signal.SIGSTOP)
    with pytest.raises(subprocess.TimeoutExpired):
        running.process.wait(0.5)  # some leases
    running.process.send_signal(signal.SIGCONT)
    running.process.terminate()
    assert running.read_result()["outcome"] == "interrupted"
    assert not of("stop") & set(running.deeds)


def test_a_run_that_ends_takes_its_guardian_with_it(start: Start) -> None:
    running = start("ends")
    assert running.read_result()["outcome"] == "success"
    assert not of("stop") & set(running.deeds)
    with pytest.raises(ProcessLookupError):
        os.kill(running.guardian, 0)


def test_without_a_guardian_nothing_drives_on(start: Start) -> None:
    running = start("drives")
    os.kill(running.guardian, signal.SIGKILL)
    result = running.read_result()
    assert (result["outcome"], running.process.returncode) == ("error", 3)
    how = signal.strsignal(signal.SIGKILL)
    assert result["reason"].startswith(f"the guardian process {running.guardian} died ({how}). Every motor was stopped")
    assert running.deeds[-1].startswith("stand")


def test_a_guardian_that_does_not_answer_ends_the_run(start: Start) -> None:
    running = start("drives")
    os.kill(running.guardian, signal.SIGSTOP)
    result = running.read_result()
    assert running.process.returncode == 3
    assert "has not answered for 2." in result["reason"]


def test_a_driver_whose_stop_hangs_leaves_it_to_the_guardian(start: Start) -> None:
    running = start("sticks")
    _, err = running.end()
    assert running.process.returncode == 3
    assert "broke off" in err
    assert_stopped(running)


def test_two_runs_at_once_have_a_guardian_each(start: Start) -> None:
    killed, other = start("drives"), start("drives")
    killed.process.kill()
    killed.end()
    assert_stopped(killed)
    assert other.guardian != killed.guardian
    other.process.terminate()
    assert other.read_result()["outcome"] == "interrupted"
    assert not of("stop") & set(other.deeds)


def test_a_cutoff_that_cannot_stop_is_reported_while_somebody_hears_it(start: Start) -> None:
    running = start("holds", "fails to stop")
    out, _ = running.end()
    assert running.process.returncode == 3
    assert "could not stop left_motor: OSError: no stop" in json.loads(out)["reason"]


def test_a_cutoff_that_cannot_stop_is_reported_where_nobody_is_left_to_hear_it(start: Start) -> None:
    running = start("drives", "fails to stop")
    running.process.kill()
    _, err = running.end()
    assert "CANNOT STOP left_motor: OSError: no stop. Cut the motors' supply" in err


def test_a_cutoff_that_cannot_stop_a_suspended_app_is_reported_at_once(start: Start) -> None:
    running = start("drives", "fails to stop")
    running.process.send_signal(signal.SIGSTOP)
    assert running.process.stderr
    assert "CANNOT STOP left_motor: OSError: no stop. Cut the motors' supply" in running.process.stderr.readline()
    running.process.kill()
    running.end()


def until(running: Running, deed: str, times: int = 1) -> None:
    """Wait for a deed; a test that waits in vain is ended by its time limit."""
    while running.deeds.count(deed) < times:
        with pytest.raises(subprocess.TimeoutExpired):
            running.process.wait(0.01)

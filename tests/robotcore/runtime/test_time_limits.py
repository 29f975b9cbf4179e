"""Whatever hangs, an app, a device, a simulator or who looks on, is stopped and told by name."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import robotcore.description
from robotcore.errors import BackendError, WatchdogError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.behaviour import Status
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.time_limits import judge_limit
from robotcore.runtime.trace import TickRecord
from robotcore.safety.motor_stop import STOP_S
from tests.robotcore.fakes import Deed, RigBackend
from tests.robotcore.runs import Runner, Watcher, ended_by, then


class Judge(Deed):
    """An app of this file."""


def test_a_judge_that_hangs_is_named_by_its_line() -> None:
    error = judge_limit(Judge(lambda _: None), "rig").error(10.0, sys._getframe())
    assert isinstance(error, WatchdogError)
    assert str(error).startswith(f"Judge has not come back from verify for 10.0 s, at {Path(__file__).name}:")


def test_a_simulator_that_does_not_tell_the_truth_is_named() -> None:
    error = judge_limit(Judge(lambda _: None), "rig").error(10.0, None)
    assert isinstance(error, BackendError)
    assert "'rig' has not told the truth" in str(error)


HASTY = "watchdog_s = 0.4\nanswer_s = 0.3\n"


@pytest.fixture
def hasty(tmp_path: Path) -> RunRequest:
    """Ask for a run of a robot whose watchdog does not wait for long."""
    rover = Path(robotcore.description.__file__).with_name("robots") / "rover.toml"
    file = tmp_path / "hasty.toml"
    file.write_text(rover.read_text().replace("max_age_s = 1.0\n", f"max_age_s = 1.0\n{HASTY}"))
    return RunRequest("an_app", robot=str(file))


@pytest.fixture
def gate() -> Iterator[threading.Event]:
    """What hangs waits for this; the test lets it go at its end."""
    event = threading.Event()
    yield event
    event.set()


@pytest.mark.parametrize("is_burning", [False, True])
def test_an_app_that_does_not_come_back_is_stopped_by_name(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event, *, is_burning: bool
) -> None:
    def hang(robot: Robot) -> None:
        while is_burning:
            pass
        gate.wait()

    watcher = Watcher()
    result = perform(then(hang), hasty, observers=[watcher])
    assert isinstance(result.error, WatchdogError)
    assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)
    assert result.reason.startswith("Deed has not come back from step for 0.")
    assert "in 'start'" in result.reason
    assert backend.rig.wheels == (0.0, 0.0)
    assert ended_by(watcher) == "watchdog"
    assert result.interventions >= 1


def test_an_app_that_swallows_it_once_ends_all_the_same(
    perform: Runner, hasty: RunRequest, gate: threading.Event
) -> None:
    def swallow(robot: Robot) -> None:
        try:
            gate.wait()
        except BaseException:  # noqa: BLE001  some apps do
            return

    assert isinstance(perform(then(swallow), hasty).error, WatchdogError)


def test_a_sensor_that_hangs_is_named(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event
) -> None:
    def hang(robot: Robot) -> None:
        backend.rig.nose._newest = gate.wait  # type: ignore[method-assign, assignment]

    result = perform(then(hang), hasty)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.startswith("nose: has not answered for 0.")
    assert backend.rig.wheels == (0.0, 0.0)
    assert backend.rig.left.releases == 1


def test_a_simulator_that_lets_no_time_pass_is_named(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event
) -> None:
    def hang(robot: Robot) -> None:
        backend.rig.clock._advance = lambda _: gate.wait()  # type: ignore[assignment]

    watcher = Watcher()
    result = perform(then(hang), hasty, observers=[watcher])
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.startswith("the backend of 'rig' has not answered for 0.")
    assert ended_by(watcher) == "watchdog"
    assert backend.rig.wheels == (0.0, 0.0)


def test_a_motor_that_hangs_keeps_the_other_from_nothing(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event
) -> None:
    def hang(robot: Robot) -> None:
        backend.rig.left.on_command = lambda _: gate.wait()

    result = perform(then(hang), hasty)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.startswith("left_motor: has not answered for 0.")
    assert backend.rig.right.sent[-1] == 0.0


def test_a_stop_that_hangs_at_the_end_is_reported_and_keeps_the_other_from_nothing(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event
) -> None:
    def hang(robot: Robot) -> None:
        backend.rig.left.on_command = lambda _: gate.wait()
        raise ValueError

    result = perform(then(hang), hasty)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
    assert "left_motor: has not stopped within 0.3 s" in result.reason
    assert backend.rig.right.sent[-1] == 0.0


def test_a_simulated_motor_may_take_as_long_over_its_stop_as_over_any_answer(
    perform: Runner, backend: RigBackend
) -> None:
    def dawdle(robot: Robot) -> None:
        wall = MonotonicClock()
        backend.rig.left.on_command = lambda _: wall.sleep_until(wall.now() + 2 * STOP_S)
        raise ValueError

    result = perform(then(dawdle))
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
    assert "has not stopped" not in result.reason


def test_an_observer_that_hangs_is_reported_where(
    perform: Runner,
    backend: RigBackend,
    hasty: RunRequest,
    gate: threading.Event,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Hung(Watcher):
        def tick(self, record: TickRecord) -> None:
            if record.tick == 3:
                gate.wait()

    monkeypatch.setattr(SteppedClock, "is_lockstep", False)  # as on a robot, whose time waits for nobody
    result = perform(then(lambda _: None), hasty, observers=[Hung()])
    assert isinstance(result.error, WatchdogError)
    assert result.reason.startswith("what looks at the run has not come back for")
    assert backend.rig.wheels == (0.0, 0.0)


def test_simulated_time_waits_for_an_observer(perform: Runner, hasty: RunRequest, gate: threading.Event) -> None:
    class Slow(Watcher):
        def tick(self, record: TickRecord) -> None:
            if record.tick == 3:
                gate.wait(1.0)

    ticks = iter([Status.RUNNING, Status.SUCCESS])
    result = perform(then(lambda _: next(ticks)), hasty, observers=[Slow()])
    assert result.outcome is Outcome.SUCCESS


def test_a_window_that_is_held_up_ends_no_run(
    perform: Runner,
    backend: RigBackend,
    hasty: RunRequest,
    gate: threading.Event,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    waits = iter([1.0])

    def drag(robot: Robot) -> Status:
        backend.rig.left.on_command = lambda _: gate.wait(next(waits, 0.0))
        robot["left_motor"].stop()  # type: ignore[attr-defined]
        return Status.SUCCESS

    monkeypatch.setattr(backend, "has_gui", True)
    assert perform(then(drag), replace(hasty, gui=True)).outcome is Outcome.SUCCESS


def test_a_backend_that_does_not_open_the_robot_is_named(
    perform: Runner, backend: RigBackend, gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.runtime.time_limits.OPENING_S", 0.3)
    monkeypatch.setattr("robotcore.safety.watchdog.FIRST_TICK_S", 0.3)
    monkeypatch.setattr(backend, "_prepare", lambda _: gate.wait())
    result = perform(then(lambda _: None))
    assert (result.outcome, result.exit_status, result.ticks) == (Outcome.ERROR, 3, 0)
    assert result.reason.startswith("the backend 'rig' has not opened the robot for")


RUN_THEN_TRACE = """
import sys, threading
from robotcore import RunRequest, run

thread = threading.Thread(target=run, args=(RunRequest("avoid-obstacles", timeout_s=0.2),))
thread.start()
thread.join()
sys.settrace(lambda *_: None)
threading.active_count()
"""
"""In a process of its own: where this hangs, nothing in the process ends it."""


@pytest.mark.skipif(sys.gettrace() is not None, reason="what is raised into a thread may end in its tracer")
def test_a_run_outside_the_main_thread_is_brought_back_from_pythons_own_code(
    perform: Runner, backend: RigBackend, hasty: RunRequest
) -> None:
    def burn(robot: Robot) -> None:
        while True:
            pass

    results: list[RunResult] = []
    thread = threading.Thread(target=lambda: results.append(perform(then(burn), hasty)))
    thread.start()
    thread.join(60)
    (result,) = results
    assert isinstance(result.error, WatchdogError)
    assert backend.rig.wheels == (0.0, 0.0)


def test_a_tracer_works_after_a_run_outside_the_main_thread() -> None:
    subprocess.run([sys.executable, "-c", RUN_THEN_TRACE], check=True, timeout=60)

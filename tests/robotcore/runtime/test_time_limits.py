"""Hangs of an app, a device, a simulator or an observer. The run ends with an error that names the part."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import robotcore.description
from robotcore.errors import BackendError, DeviceError, WatchdogError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.behaviour import Status
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome
from robotcore.runtime.time_limits import judge_limit
from robotcore.runtime.trace import TickRecord
from robotcore.safety.motor_stop import STOP_S
from tests.robotcore.fakes import FunctionApp, Rig, RigBackend
from tests.robotcore.runs import Runner, Watcher, drive_then, last_cause
from tests.texts import CheckText


class Judge(FunctionApp):
    """An app of this module."""


def test_error_of_a_judge_that_hangs_has_its_line(check_text: CheckText) -> None:
    frame = sys._getframe()
    line = frame.f_lineno + 1
    error = judge_limit(Judge(lambda _: None), "rig").error(10.0, frame)
    assert isinstance(error, WatchdogError)
    assert error.kind == "verify-timeout"
    check_text(error, hide=[f":{line}"])


def test_error_of_a_simulator_that_returns_no_truth_has_its_name(check_text: CheckText) -> None:
    error = judge_limit(Judge(lambda _: None), "rig").error(10.0, None)
    assert isinstance(error, BackendError)
    assert error.kind == "truth-timeout"
    check_text(error)


HASTY = "watchdog_s = 0.4\nanswer_s = 0.3\n"


@pytest.mark.slow
def test_note_that_cannot_be_written_does_not_block_the_watchdog(
    perform: Runner, hasty: RunRequest, gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.safety.watchdog.NOTICE_S", 0.1)
    monkeypatch.setattr("robotcore.safety.watchdog.FIRST_TICK_S", 0.3)
    monkeypatch.setattr("robotcore.runtime.session.os.write", lambda *_: gate.wait())

    def hang(robot: Robot) -> None:
        gate.wait(10.0)

    result = perform(FunctionApp(hang), hasty)
    assert isinstance(result.error, WatchdogError)
    assert len(result.notes) == 1


@pytest.fixture
def hasty(tmp_path: Path) -> RunRequest:
    """The request of a run with a robot whose time limits are short."""
    rover = Path(robotcore.description.__file__).with_name("robots") / "rover.toml"
    file = tmp_path / "hasty.toml"
    file.write_text(rover.read_text().replace("max_age_s = 1.0\n", f"max_age_s = 1.0\n{HASTY}"))
    return RunRequest("an_app", robot=str(file))


@pytest.fixture
def gate() -> Iterator[threading.Event]:
    """The event for which hanging functions wait. It is set at the end of the test."""
    event = threading.Event()
    yield event
    event.set()


@pytest.mark.slow
@pytest.mark.parametrize("is_burning", [False, True])
def test_app_that_does_not_return_is_stopped(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event, *, is_burning: bool
) -> None:
    def hang(robot: Robot) -> None:
        while is_burning:
            pass
        gate.wait()

    watcher = Watcher()
    result = perform(drive_then(hang), hasty, observers=[watcher])
    assert isinstance(result.error, WatchdogError)
    assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)
    assert (result.error.kind, result.error.fields["state"]) == ("step-timeout", "start")
    assert backend.rig.wheels == (0.0, 0.0)
    assert last_cause(watcher) == "watchdog"
    assert result.interventions >= 1
    assert "watchdog" in result.intervention_s


def hang_sensor(rig: Rig, gate: threading.Event) -> None:
    rig.nose._newest = gate.wait  # type: ignore[method-assign, assignment]


def hang_simulator(rig: Rig, gate: threading.Event) -> None:
    rig.clock._advance = lambda _: gate.wait()  # type: ignore[assignment]


def hang_motor(rig: Rig, gate: threading.Event) -> None:
    rig.left.on_command = lambda _: gate.wait()


@pytest.mark.slow
@pytest.mark.parametrize("hang, device", [(hang_sensor, "nose"), (hang_simulator, None), (hang_motor, "left_motor")])
def test_error_of_a_part_that_hangs_has_its_name_and_the_motors_stop(
    perform: Runner,
    backend: RigBackend,
    hasty: RunRequest,
    gate: threading.Event,
    hang: Callable[[Rig, threading.Event], None],
    device: str | None,
) -> None:
    watcher = Watcher()
    result = perform(drive_then(lambda _: hang(backend.rig, gate)), hasty, observers=[watcher])
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, DeviceError if device else BackendError)
    assert getattr(result.error, "device", None) == device
    assert last_cause(watcher) == "watchdog"
    assert backend.rig.right.sent[-1] == 0.0
    if hang is not hang_motor:
        assert backend.rig.left.sent[-1] == 0.0
        assert backend.rig.left.releases == 1


@pytest.mark.slow
def test_stop_that_hangs_at_the_end_is_reported_and_the_other_motor_stops(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event, check_text: CheckText
) -> None:
    def hang(robot: Robot) -> None:
        backend.rig.left.on_command = lambda _: gate.wait()
        raise ValueError

    result = perform(drive_then(hang), hasty)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
    check_text(result.reason)
    assert backend.rig.right.sent[-1] == 0.0


@pytest.mark.slow
def test_every_motor_whose_stop_hangs_at_the_end_is_named(
    perform: Runner, backend: RigBackend, hasty: RunRequest, gate: threading.Event, check_text: CheckText
) -> None:
    def hang(robot: Robot) -> None:
        for motor in (backend.rig.left, backend.rig.right):
            motor.on_command = lambda _: gate.wait()
        raise ValueError

    check_text(perform(drive_then(hang), hasty).reason)


@pytest.mark.slow
def test_slow_stop_of_a_simulated_motor_is_no_hang(perform: Runner, backend: RigBackend, check_text: CheckText) -> None:
    def dawdle(robot: Robot) -> None:
        wall = MonotonicClock()
        backend.rig.left.on_command = lambda _: wall.sleep_until(wall.now() + 2 * STOP_S)
        raise ValueError

    result = perform(drive_then(dawdle))
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
    check_text(result.reason)


@pytest.mark.slow
def test_observer_that_hangs_ends_the_run(
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

    monkeypatch.setattr(SteppedClock, "is_lockstep", False)  # as on a real robot
    result = perform(drive_then(lambda _: None), hasty, observers=[Hung()])
    assert isinstance(result.error, WatchdogError)
    assert result.error.kind == "observer-timeout"
    assert backend.rig.wheels == (0.0, 0.0)


@pytest.mark.slow
def test_simulated_time_waits_for_an_observer(perform: Runner, hasty: RunRequest, gate: threading.Event) -> None:
    class Slow(Watcher):
        def tick(self, record: TickRecord) -> None:
            if record.tick == 3:
                gate.wait(1.0)

    ticks = iter([Status.RUNNING, Status.SUCCESS])
    result = perform(drive_then(lambda _: next(ticks)), hasty, observers=[Slow()])
    assert result.outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_dragged_window_ends_no_run(
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
    assert perform(drive_then(drag), replace(hasty, gui=True)).outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_backend_that_does_not_open_the_robot_ends_the_run(
    perform: Runner, backend: RigBackend, gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.runtime.time_limits.OPENING_S", 0.3)
    monkeypatch.setattr("robotcore.safety.watchdog.FIRST_TICK_S", 0.3)
    monkeypatch.setattr(backend, "_prepare", lambda _: gate.wait())
    result = perform(drive_then(lambda _: None))
    assert (result.outcome, result.exit_status, result.ticks) == (Outcome.ERROR, 3, 0)
    assert isinstance(result.error, BackendError)
    assert result.error.kind == "opening-timeout"

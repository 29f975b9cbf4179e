"""Every end of a run stops every motor, and has an outcome."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest

from robotcore.errors import (
    BehaviourError,
    DeviceClosedError,
    EmergencyStopError,
    Interrupted,
    UsageError,
    WatchdogError,
)
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunContext
from robotcore.runtime.signals import SignalGuard
from robotcore.runtime.trace import TickRecord
from tests.robotcore.fakes import RigBackend
from tests.robotcore.runs import Runner, Watcher, drive_then, drive_then_raise, drive_wheels, last_cause


def test_no_command_passes_after_the_third_signal(
    perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    robots: list[Robot] = []
    died: list[tuple[float, float]] = []

    def end_by_signal(number: int) -> None:
        with pytest.raises(DeviceClosedError):
            drive_wheels(robots[0])
        died.append(backend.rig.wheels)

    def press(robot: Robot) -> None:
        robots.append(robot)
        for _ in range(3):
            with suppress(Interrupted):
                signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("robotcore.runtime.signals.end_by_signal", end_by_signal)
    perform(drive_then(press))
    assert died == [(0.0, 0.0)]


def test_late_watchdog_interrupt_ends_the_run_with_the_latched_error(
    perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    latched = WatchdogError("too late")
    mask, last_moment = SignalGuard.mask, iter([latched])

    def mask_too_late(guard: SignalGuard) -> None:
        for error in last_moment:
            runs[0].latch.set(error)
            guard.interrupt_main_thread()
        mask(guard)

    runs: list[AssembledRobot] = []

    def keep(*parts: Any) -> AssembledRobot:
        runs.append(assemble(*parts))
        return runs[0]

    monkeypatch.setattr("robotcore.runtime.session.assemble", keep)
    monkeypatch.setattr(SignalGuard, "mask", mask_too_late)
    result = perform(drive_then(lambda _: Status.SUCCESS))
    assert (result.outcome, result.error) == (Outcome.STOPPED, latched)
    assert backend.rig.left.releases == 1


class Button(Watcher):
    """Presses the e-stop from another thread at the third tick."""

    def begin(self, run: RunContext) -> None:
        self.run = run

    def tick(self, record: TickRecord) -> None:
        super().tick(record)
        if record.tick == 3:
            thread = threading.Thread(target=self.run.emergency.press, args=("the button was pressed",))
            thread.start()
            thread.join()


def drive_and_catch(robot: Robot) -> None:
    with suppress(BaseException):
        drive_wheels(robot)


@pytest.mark.parametrize("end", [drive_wheels, drive_and_catch])
def test_e_stop_ends_the_run_even_if_the_app_catches_the_error(
    perform: Runner, backend: RigBackend, end: Callable[[Robot], None]
) -> None:
    button = Button()
    result = perform(drive_then(end), observers=[button])
    assert (result.outcome, result.exit_status, result.ticks) == (Outcome.STOPPED, 4, 5)
    assert isinstance(result.error, EmergencyStopError)
    assert result.reason == "e-stop: the button was pressed"
    assert last_cause(button) == "e-stop"
    assert backend.rig.wheels == (0.0, 0.0)


@pytest.mark.parametrize("kind", [SystemExit, KeyboardInterrupt, GeneratorExit, MemoryError, UsageError])
def test_any_exception_of_an_app_ends_its_run(perform: Runner, backend: RigBackend, kind: type[BaseException]) -> None:
    result = perform(drive_then_raise(kind("so")))
    assert isinstance(result.error, BehaviourError)
    assert result.exit_status == 5
    assert backend.rig.wheels == (0.0, 0.0)


def test_threads_of_an_app_move_nothing_after_the_run(perform: Runner, backend: RigBackend) -> None:
    refused: list[str] = []

    def command(robot: Robot) -> None:
        for drive in (robot.drive.set_velocity, robot.drive.set_wheels):
            with pytest.raises(DeviceClosedError):
                drive(-0.1, -0.1)
        refused.append("all")

    def end(robot: Robot) -> Status:
        backend.rig.right._release = lambda: command(robot)  # type: ignore[method-assign]
        kept.append(robot)
        return Status.SUCCESS

    kept: list[Robot] = []
    assert perform(drive_then(end)).outcome is Outcome.SUCCESS
    command(kept[0])
    kept[0].drive.stop()
    assert refused == ["all", "all"]
    assert backend.rig.wheels == (0.0, 0.0)


class TestObservers:
    @pytest.mark.parametrize("method", ["begin", "tick", "end"])
    def test_observer_that_raises_stops_the_motors_and_the_others_get_the_result(
        self, perform: Runner, backend: RigBackend, method: str
    ) -> None:
        broken, watcher = Watcher(), Watcher()
        setattr(broken, method, lambda _: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            perform(drive_then(lambda _: Status.SUCCESS), observers=[broken, watcher])
        assert backend.rig.wheels == (0.0, 0.0)
        assert backend.rig.left.releases == 1
        (result,) = [value for name, value in watcher.calls if name == "end"]
        assert result.outcome is (Outcome.SUCCESS if method == "end" else Outcome.ERROR)

    def test_signal_does_not_interrupt_the_beginning(self, perform: Runner) -> None:
        class Beginning(Watcher):
            def begin(self, run: RunContext) -> None:
                signal.raise_signal(signal.SIGINT)
                super().begin(run)

        observers = [Beginning(), Watcher()]
        result = perform(drive_then(drive_wheels), observers=observers)
        assert (result.outcome, result.ticks) == (Outcome.INTERRUPTED, 0)
        assert [[name for name, _ in each.calls] for each in observers] == [["begin", "end"]] * 2


@pytest.mark.slow
def test_motors_stand_before_the_program_is_suspended(perform: Runner, backend: RigBackend) -> None:
    stood: list[Any] = []
    held: list[int] = []
    before = signal.signal(signal.SIGTSTP, lambda *_: stood.append(backend.rig.wheels))

    def press(robot: Robot) -> None:
        signal.raise_signal(signal.SIGTSTP)
        held.append(len(stood))

    try:
        result = perform(drive_then(press), RunRequest("an_app", timeout_s=0.2))
    finally:
        signal.signal(signal.SIGTSTP, before)
    assert set(stood) == {(0.0, 0.0)}
    assert held == list(range(len(stood))), "it waits for the end of the tick"
    assert result.outcome is Outcome.TIMEOUT


@pytest.mark.posix("it suspends the program")
def test_sample_after_a_suspension_is_new(perform: Runner, backend: RigBackend) -> None:
    waking: list[threading.Timer] = []

    def suspend(*_: object) -> None:
        backend.rig.nose.age = 3600.0
        waking.append(threading.Timer(0.05, setattr, (backend.rig.nose, "age", 0.0)))
        waking[-1].start()

    ticks = iter([signal.SIGTSTP, None, None])

    def press(robot: Robot) -> Status:
        robot.range.read()
        number = next(ticks)
        if number:
            signal.raise_signal(number)
        return Status.RUNNING if number else Status.SUCCESS

    before = signal.signal(signal.SIGTSTP, suspend)
    try:
        result = perform(drive_then(press))
    finally:
        signal.signal(signal.SIGTSTP, before)
    waking[-1].join()
    assert result.outcome is Outcome.SUCCESS

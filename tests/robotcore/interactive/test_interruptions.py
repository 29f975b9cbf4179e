"""The ways out of a session: signals, exceptions, forks and hangs. `benchmarks.interruptions` measures the stops."""

from __future__ import annotations

import os
import signal
import threading
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

import robotcore
from robotcore import LiveRobot, Outcome, Role, Routine
from robotcore.errors import DeviceError, Interrupted, UsageError, WatchdogError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording import read
from robotcore.runtime.loop import Loop
from robotcore.runtime.session import RunSession
from robotcore.runtime.signals import SignalGuard
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble
from tests.robotcore.safety.guardian.doubles import RecordingBackend
from tests.robotcore.safety.guardian.recorder import notes
from tests.texts import Raises


@pytest.fixture(autouse=True)
def received() -> Iterator[list[int]]:
    """Install the handlers of a program, and return a list to which the handler of SIGTERM adds its signals."""
    signals: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _: signals.append(number))
    interrupt = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield signals
    signal.signal(signal.SIGTERM, before)
    signal.signal(signal.SIGINT, interrupt)


def is_running() -> bool:
    """Return whether a session's watchdog runs."""
    return any(thread.name == "watchdog" for thread in threading.enumerate())


def raise_signals(*numbers: int) -> Routine[None]:
    for number in numbers:
        signal.raise_signal(number)
    yield


def test_two_interrupts_in_a_tick_end_one_call() -> None:
    with robotcore.open(world="open") as robot:
        with pytest.raises(KeyboardInterrupt) as caught:
            robot.run(raise_signals(signal.SIGINT, signal.SIGINT))
        assert caught.value.__suppress_context__
        robot.wait(0.1)


def test_close_after_an_interrupted_call_raises_nothing() -> None:
    robot = robotcore.open(world="open")
    with pytest.raises(KeyboardInterrupt):
        robot.run(raise_signals(signal.SIGINT))
    robot.close()
    robot.close()


def test_signal_in_the_tick_of_an_exception_is_not_lost(received: list[int]) -> None:
    def fail() -> Routine[None]:
        yield from raise_signals(signal.SIGTERM)
        raise ValueError

    robot = robotcore.open(world="open")
    with pytest.raises(Interrupted):
        robot.run(fail())
    assert received == [signal.SIGTERM]
    assert robot.result
    assert robot.result.outcome is Outcome.INTERRUPTED


@pytest.mark.parametrize("number, error", [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Interrupted)])
def test_signal_during_close_acts_after_it(
    monkeypatch: pytest.MonkeyPatch, received: list[int], number: int, error: type[BaseException]
) -> None:
    close = RunSession.close

    def interrupt(self: RunSession, *arguments: Any) -> Any:
        signal.raise_signal(number)
        result = close(self, *arguments)
        assert not received
        return result

    robot = robotcore.open(world="open")
    monkeypatch.setattr(RunSession, "close", interrupt)
    with pytest.raises(error):
        robot.close()
    assert robot.result
    assert robot.result.outcome is Outcome.SUCCESS


@pytest.mark.parametrize("number, error", [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Interrupted)])
@pytest.mark.parametrize("is_open", [False, True])
def test_signal_during_open_closes_the_robot(
    monkeypatch: pytest.MonkeyPatch, received: list[int], number: int, error: type[BaseException], *, is_open: bool
) -> None:
    run_open = RunSession.open

    def interrupt(self: RunSession) -> Loop | None:
        loop = run_open(self) if is_open else None
        signal.raise_signal(number)
        return loop

    monkeypatch.setattr(RunSession, "open", interrupt)
    with pytest.raises(error):
        robotcore.open(world="open")
    assert not is_running()
    assert received == [signal.SIGTERM] * (number == signal.SIGTERM)


def test_interrupt_between_two_calls_leaves_the_robot_open() -> None:
    with robotcore.open(world="open") as robot:
        robot.drive.straight(0.1)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        assert robot.drive.straight(0.1).x == pytest.approx(0.2, abs=0.01)
    assert robot.result
    assert robot.result.outcome is Outcome.SUCCESS


def test_signal_in_a_program_that_handles_signals_closes_the_robot() -> None:
    with SignalGuard(), pytest.raises(Interrupted), robotcore.open() as robot:
        robot.run(raise_signals(signal.SIGINT))
    assert robot.result


def test_signal_between_two_calls_reaches_the_handler_of_the_program_only(received: list[int]) -> None:
    with robotcore.open(world="open") as robot:
        robot.wait(0.1)
        signal.raise_signal(signal.SIGTERM)
        assert received == [signal.SIGTERM]
        robot.wait(0.1)
    assert robot.result
    assert robot.result.outcome is Outcome.SUCCESS


@pytest.mark.slow
@pytest.mark.parametrize("number, error", [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Interrupted)])
def test_signal_while_a_lost_robot_is_closed_acts_after_it(
    monkeypatch: pytest.MonkeyPatch, number: int, error: type[BaseException]
) -> None:
    lost = robotcore.open(world="open")._session
    close = RunSession.close

    def interrupt(self: RunSession, *arguments: Any) -> Any:
        signal.raise_signal(number)
        return close(self, *arguments)

    monkeypatch.setattr(RunSession, "close", interrupt)
    with pytest.raises(error):
        robotcore.open(world="open")
    assert lost.result
    assert lost.result.outcome is Outcome.SUCCESS
    assert not is_running()


def test_interrupt_that_python_discards_during_open_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    run_open = RunSession.open

    def interrupt(self: RunSession) -> Loop | None:
        loop = run_open(self)
        with suppress(Interrupted):  # as Python does in a callback of a weak reference
            signal.raise_signal(signal.SIGINT)
        return loop

    monkeypatch.setattr(RunSession, "open", interrupt)
    with pytest.raises(KeyboardInterrupt):
        robotcore.open(world="open")
    assert not is_running()


def test_interrupt_of_the_first_tick_closes_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(self: LiveRobot, seconds: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(LiveRobot, "wait", interrupt)
    with pytest.raises(KeyboardInterrupt):
        robotcore.open(world="open")
    assert not is_running()


def test_error_of_open_does_not_show_the_frames_of_the_run() -> None:
    with pytest.raises(DeviceError) as caught:
        robotcore.open("rover", "serial", options={"port": "/dev/nowhere"}, needs={Role.DRIVE})
    assert len(traceback.extract_tb(caught.value.__traceback__)) <= 3


def test_exception_in_the_with_block_is_a_failure() -> None:
    with pytest.raises(ZeroDivisionError), robotcore.open(world="open") as robot:
        raise ZeroDivisionError
    assert robot.result
    assert robot.result.outcome is Outcome.FAILURE


@pytest.mark.parametrize("error", [SystemExit, KeyboardInterrupt, GeneratorExit, RecursionError])
def test_any_exception_of_a_routine_ends_the_call_only(error: type[BaseException]) -> None:
    def fail() -> Routine[None]:
        yield
        raise error

    with robotcore.open(world="open") as robot:
        with pytest.raises(error):
            robot.run(fail())
        robot.drive.straight(0.05)


def test_routine_that_catches_everything_is_interrupted() -> None:
    def persist(robot: LiveRobot) -> Routine[None]:
        for number in range(5):
            try:
                robot.drive.set_velocity(0.2, 0.0)
                if number == 0:  # a third signal would end the process at once
                    signal.raise_signal(signal.SIGINT)
                yield
            except BaseException:  # noqa: S110, BLE001, PERF203  as a beginner's code may
                pass

    with robotcore.open(world="open") as robot:
        with pytest.raises(KeyboardInterrupt):
            robot.run(persist(robot))
        robot.wait(0.1)
        assert robot.ground_truth
        assert robot.ground_truth.is_at_rest


@pytest.mark.slow
def test_hang_of_a_routine_is_reported_with_its_line() -> None:
    def hang() -> Routine[None]:
        yield
        while True:
            pass

    with robotcore.open(world="open") as robot, pytest.raises(WatchdogError, match="test_interruptions"):
        robot.run(hang())
    assert robot.result
    assert robot.result.outcome is Outcome.STOPPED


def test_failed_stop_after_a_call_leaves_no_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(cause: str) -> None:
        raise DeviceError("left_motor", cause)

    with robotcore.open(world="open") as robot:
        assert robot._loop
        with monkeypatch.context() as patch:
            patch.setattr(robot._loop, "_stop", fail)
            with pytest.raises(DeviceError):
                robot.wait(0.1)
        assert robot._session._activity.activity is None


def test_other_thread_cannot_close_the_robot(raises: Raises) -> None:
    failures: list[BaseException] = []

    def close() -> None:
        try:
            robot.close()
        except UsageError as error:
            failures.append(error)

    with robotcore.open(world="open") as robot:
        thread = threading.Thread(target=close)
        thread.start()
        thread.join()
        with raises(UsageError, "wrong-thread"):
            raise failures[0]
        assert robot.result is None
        robot.drive.straight(0.05)


def test_copy_of_the_process_cannot_use_or_close_the_robot() -> None:
    with robotcore.open(world="open") as robot:
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks of a process that has threads
        if not (child := os.fork()):
            status = 1
            try:
                robot.wait(0.1)
            except UsageError as error:
                robot.close()
                status = 0 if error.kind == "wrong-process" and robot.result is None else 1
            finally:
                os._exit(status)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        robot.drive.straight(0.05)


@pytest.mark.slow
def test_motors_and_guardian_get_no_command_while_a_session_is_idle(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    diary = tmp_path / "diary"
    backend = RecordingBackend(diary)
    for module in ("runtime.plan", "interactive.opening"):
        monkeypatch.setattr(f"robotcore.{module}.load_backend", lambda _: backend)
    with robotcore.open("rover", "recording", needs={Role.DRIVE}) as robot:
        robot.drive.move(0.2, seconds=0.2)
        before = notes(diary)
        time.sleep(0.6)  # more than three leases
        assert notes(diary) == before
        robot.drive.move(0.2, seconds=0.2)
    assert any(note.action.startswith("turn") for note in notes(diary)[len(before) :])


@pytest.mark.slow
def test_session_on_a_board_in_real_time(tmp_path: Path) -> None:
    file, clock = tmp_path / "session.mcap", MonotonicClock()
    with ExitStack() as stack:
        stack.callback(clock.close)
        pty, board = stack.enter_context(Pty(tmp_path)), RobotcoreBridgeDouble()
        stack.callback(Powered(board, pty, clock).off)
        options = {"port": str(pty.path)}
        with robotcore.open("rover", "serial", options=options, needs={Role.DRIVE}, record=file) as robot:
            robot.drive.move(0.2, seconds=0.3)
            encoder: Any = robot["left_encoder"]
            time.sleep(0.5)  # the wheels come to rest
            before = encoder.read().angle
            time.sleep(1.3)  # longer than the greatest age of a sample
            board.wheels.left.angle += 1.0
            time.sleep(0.3)
            assert encoder.read().angle - before >= 0.9
            assert robot.clock.now() - encoder.read().time < 0.2
            robot.drive.move(0.2, seconds=0.3)
            assert encoder.read().angle > before + 1.1
    assert robot.result
    assert robot.result.outcome is Outcome.SUCCESS
    recording = read(file)
    assert len(recording.ticks) == robot.result.ticks

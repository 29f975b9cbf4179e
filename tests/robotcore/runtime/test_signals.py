from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

from robotcore.errors import Interrupted
from robotcore.hal.robot import Robot
from robotcore.runtime import signals
from robotcore.runtime.signals import END_SIGNALS, LAST_SIGNAL, WATCHDOG_SIGNAL, SignalGuard, WatchdogInterrupt
from robotcore.system import HAS_POSIX
from tests.robotcore.fakes import FunctionApp
from tests.robotcore.runs import Runner

SIGNALS = END_SIGNALS


@pytest.fixture(autouse=True)
def _own_handlers() -> Iterator[None]:
    """Install the handlers of a program that was started from a terminal."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    for number in SIGNALS:
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


class TestSignalGuard:
    @pytest.mark.parametrize("number", SIGNALS)
    def test_signal_raises_past_a_handler_of_exceptions(self, number: signal.Signals) -> None:
        with pytest.raises(Interrupted) as raised, SignalGuard(), suppress(Exception):
            signal.raise_signal(number)
        assert raised.value.exit_status == 128 + number

    def test_check_raises_a_caught_signal_again(self) -> None:
        with SignalGuard() as guard:
            guard.check()
            with pytest.raises(Interrupted):
                signal.raise_signal(signal.SIGTERM)
            with pytest.raises(Interrupted) as raised:
                guard.check()
        assert raised.value.exit_status == 128 + signal.SIGTERM

    def test_deferred_signal_replaces_another_exception(self) -> None:
        def fail() -> None:
            signal.raise_signal(signal.SIGTERM)
            raise ValueError

        with pytest.raises(Interrupted), SignalGuard() as guard, guard.defer():
            fail()

    def test_reset_forgets_signals_and_the_mask(self) -> None:
        with SignalGuard() as guard:
            guard.mask()
            signal.raise_signal(signal.SIGTERM)
            assert guard.last == signal.SIGTERM
            guard.reset()
            assert guard.last is None
            with pytest.raises(Interrupted):
                signal.raise_signal(signal.SIGTERM)

    def test_signal_that_was_lost_before_a_run_prevents_the_run(self, perform: Runner) -> None:
        steps: list[Robot] = []
        with SignalGuard():
            with suppress(Interrupted):  # as Python does in a callback of a weak reference
                signal.raise_signal(signal.SIGINT)
            with pytest.raises(Interrupted):
                perform(FunctionApp(steps.append))
        assert not steps

    def test_masked_guard_begins_after_a_signal_in_an_outer_guard(self) -> None:
        closed: list[str] = []
        with SignalGuard(), suppress(Interrupted):
            try:
                signal.raise_signal(signal.SIGINT)
            finally:
                guard = SignalGuard()
                guard.mask()
                with guard:
                    closed.append("robot")
        assert closed == ["robot"]

    def test_error_of_a_library_does_not_replace_the_signal(self) -> None:
        def convert() -> None:
            with suppress(Interrupted):
                signal.raise_signal(signal.SIGINT)
            raise RuntimeError("Error calling __set_name__")

        with pytest.raises(Interrupted), SignalGuard():
            convert()

    def test_third_signal_stops_the_motors_and_ends_the_process(self, monkeypatch: pytest.MonkeyPatch) -> None:
        ended: list[int | str] = []

        def die(number: int) -> None:
            ended.append(number)
            raise SystemExit

        def stop() -> None:
            signal.raise_signal(signal.SIGTERM)  # a fourth signal does not interrupt the stop
            ended.append("stopped")

        monkeypatch.setattr("robotcore.runtime.signals.end_by_signal", die)
        with SignalGuard() as guard:
            guard.last_resort = stop
            for _ in range(2):
                with pytest.raises(Interrupted):
                    signal.raise_signal(signal.SIGTERM)
            assert not ended
            with pytest.raises(SystemExit):
                signal.raise_signal(signal.SIGTERM)
        assert ended == ["stopped", signal.SIGTERM]

    def test_third_signal_ends_the_process_while_it_writes_its_result(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def die(number: int) -> None:
            raise SystemExit(number)

        monkeypatch.setattr("robotcore.runtime.signals.end_by_signal", die)
        with SignalGuard() as command:
            with SignalGuard() as run:
                with pytest.raises(Interrupted):
                    signal.raise_signal(signal.SIGTERM)
                run.mask()
            command.mask(but_last=True)
            signal.raise_signal(signal.SIGTERM)
            with pytest.raises(SystemExit) as ended:
                signal.raise_signal(signal.SIGINT)
        assert ended.value.code == signal.SIGINT

    def test_deferred_signal_raises_at_the_end(self) -> None:
        done: list[str] = []

        def run_deferred(guard: SignalGuard) -> None:
            with guard.defer():
                signal.raise_signal(signal.SIGTERM)
                done.append("all")

        with SignalGuard() as guard, pytest.raises(Interrupted) as raised:
            run_deferred(guard)
        assert raised.value.exit_status == 128 + signal.SIGTERM
        assert done == ["all"]

    def test_previous_handlers_are_restored(self) -> None:
        before = [signal.getsignal(number) for number in SIGNALS]
        with SignalGuard():
            assert [signal.getsignal(number) for number in SIGNALS] != before
        assert [signal.getsignal(number) for number in SIGNALS] == before

    @pytest.mark.parametrize("number", [each for each in SIGNALS if each not in (signal.SIGINT, signal.SIGTERM)])
    def test_ignored_signal_stays_ignored(self, number: signal.Signals) -> None:
        signal.signal(number, signal.SIG_IGN)
        with SignalGuard():
            signal.raise_signal(number)

    @pytest.mark.posix("on Windows only the wait of time.sleep ends")
    def test_watchdog_interrupts_a_waiting_call(self) -> None:
        with SignalGuard() as guard:
            timer = threading.Timer(0.05, guard.interrupt_main_thread)

            def wait() -> None:
                timer.start()
                threading.Event().wait(30)  # on a busy machine the interrupt may come first

            with pytest.raises(WatchdogInterrupt):
                wait()
            timer.join()

    def test_without_posix_the_watchdog_raises_sigint_and_a_later_ctrl_c_is_still_one(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(signals, "HAS_POSIX", False)
        with SignalGuard() as guard:
            with pytest.raises(WatchdogInterrupt):
                guard.interrupt_main_thread()
            with pytest.raises(Interrupted):
                signal.raise_signal(signal.SIGINT)

    def test_without_posix_the_watchdog_also_interrupts_an_inner_context(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(signals, "HAS_POSIX", False)
        with SignalGuard() as guard:
            with SignalGuard() as inner, pytest.raises(WatchdogInterrupt):
                guard.interrupt_main_thread()
            assert (inner.count, inner.raised) == (0, None)
            with pytest.raises(Interrupted):
                signal.raise_signal(signal.SIGINT)

    def test_without_posix_the_watchdog_interrupts_the_outer_context_if_the_inner_one_ends_before_the_signal(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(signals, "HAS_POSIX", False)
        raise_signal = signal.raise_signal
        inner = ExitStack()

        def raise_late(number: int) -> None:
            inner.close()
            raise_signal(number)

        monkeypatch.setattr(signal, "raise_signal", raise_late)
        with SignalGuard() as guard:
            inner.enter_context(SignalGuard())
            with pytest.raises(WatchdogInterrupt):
                guard.interrupt_main_thread()
            with pytest.raises(Interrupted):
                raise_signal(signal.SIGINT)

    def test_without_posix_sigterm_before_the_sigint_of_the_watchdog_is_no_interrupt_of_the_watchdog(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(signals, "HAS_POSIX", False)
        raise_signal = signal.raise_signal
        monkeypatch.setattr(signal, "raise_signal", lambda _: raise_signal(signal.SIGTERM))
        with SignalGuard() as guard:
            with pytest.raises(Interrupted):
                guard.interrupt_main_thread()
            with pytest.raises(WatchdogInterrupt):
                raise_signal(signal.SIGINT)

    def test_watchdog_interrupt_after_the_mask_raises_nothing(self) -> None:
        with SignalGuard() as guard:
            guard.mask()
            signal.raise_signal(WATCHDOG_SIGNAL or signal.SIGINT)
            guard.interrupt_main_thread()

    def test_guard_outside_the_main_thread_handles_no_signals(self) -> None:
        before = signal.getsignal(signal.SIGINT)
        seen: list[object] = []

        def enter() -> None:
            with SignalGuard():
                seen.append(signal.getsignal(signal.SIGINT))

        thread = threading.Thread(target=enter)
        thread.start()
        thread.join()
        assert seen == [before]


@pytest.mark.parametrize("number", SIGNALS)
def test_process_dies_of_the_signal_despite_a_handler(number: signal.Signals) -> None:
    handle = f"import signal; signal.signal({number}, lambda *_: print('heard'))"
    code = f"{handle}; from robotcore.runtime.signals import end_by_signal; end_by_signal({number})"
    status = -number if HAS_POSIX else 128 + number
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == status


Starter = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start() -> Iterator[Starter]:
    """Return a function that starts a run in another process, and waits until it moves."""
    with ExitStack() as processes:

        def run(*app: str, stderr: int = subprocess.PIPE) -> subprocess.Popen[str]:
            process = processes.enter_context(
                subprocess.Popen(
                    [sys.executable, "-m", "tests.robotcore.runtime.interrupted_run", *app],
                    cwd=Path(__file__).parents[3],
                    stdout=subprocess.PIPE,
                    stderr=stderr,
                    text=True,
                )
            )
            processes.callback(process.kill)
            assert process.stdout
            assert process.stdout.readline() == "moving\n"
            return process

        yield run


@pytest.mark.slow
@pytest.mark.parametrize(
    "app, number",
    [
        ("ordinary", signal.SIGTERM),
        ("hung", signal.SIGINT),
        ("waiting", signal.SIGTERM),
        ("waiting", signal.SIGINT),
        ("deaf", signal.SIGTERM),
    ],
)
def test_signal_stops_the_motors_and_ends_the_run(start: Starter, app: str, number: signal.Signals) -> None:
    process = start(app)
    process.send_signal(number)
    result = json.loads(process.communicate(timeout=60)[0].splitlines()[-1])
    assert process.returncode == 128 + number
    assert (result["outcome"], result["reason"]) == ("interrupted", f"interrupted by {number.name}")
    assert (result["wheels"], result["releases"]) == ([0.0, 0.0], [1, 1])


@pytest.mark.slow
@pytest.mark.parametrize("app", [["impervious"], ["beyond_python"], ["hung", "in_a_thread"]])
def test_process_of_an_app_that_never_returns_ends_after_stop_and_report(start: Starter, app: list[str]) -> None:
    process = start(*app)
    output, errors = process.communicate(timeout=60)
    *_, observed, result = output.splitlines()
    assert (process.returncode, observed) == (4, "observed")
    assert (json.loads(result)["outcome"], json.loads(result)["wheels"]) == ("stopped", [0.0, 0.0])
    assert f"in {app[0]}" in errors, "the lines of every thread"


@pytest.mark.slow
def test_full_stderr_does_not_keep_a_process_whose_app_never_returns(start: Starter) -> None:
    receiver, sender = os.pipe()
    os.set_blocking(sender, False)
    with suppress(BlockingIOError):
        while True:
            os.write(sender, b"x")
    os.set_blocking(sender, True)
    process = start("beyond_python", stderr=sender)
    process.communicate(timeout=60)
    os.close(sender)
    os.close(receiver)
    assert process.returncode == 4


@pytest.mark.slow
def test_third_signal_ends_the_process_after_stop_and_report(start: Starter) -> None:
    process = start("impervious")
    assert process.stdout
    for _ in range(LAST_SIGNAL):
        assert process.stdout.readline() == "impervious\n"
        process.send_signal(signal.SIGTERM)
    observed, result = process.communicate(timeout=60)[0].splitlines()
    assert (process.returncode, observed) == (-signal.SIGTERM, "observed")
    assert (json.loads(result)["outcome"], json.loads(result)["wheels"]) == ("interrupted", [0.0, 0.0])

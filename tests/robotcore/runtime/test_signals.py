from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from robotcore.errors import Interrupted
from robotcore.runtime.signals import LAST_SIGNAL, WATCHDOG_SIGNAL, SignalGuard, WatchdogInterrupt

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]

RUN = Path(__file__).with_name("interrupted_run.py")


@pytest.fixture(autouse=True)
def _own_handlers() -> Iterator[None]:
    """Install the handlers of a program that was started from a terminal."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
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
            guard.set_last_resort(stop)
            for _ in range(2):
                with pytest.raises(Interrupted):
                    signal.raise_signal(signal.SIGTERM)
            assert not ended
            with pytest.raises(SystemExit):
                signal.raise_signal(signal.SIGTERM)
        assert ended == ["stopped", signal.SIGTERM]

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

    @pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGQUIT])
    def test_ignored_signal_stays_ignored(self, number: signal.Signals) -> None:
        signal.signal(number, signal.SIG_IGN)
        with SignalGuard():
            signal.raise_signal(number)

    def test_watchdog_interrupts_a_waiting_call(self) -> None:
        with SignalGuard() as guard:
            timer = threading.Timer(0.05, guard.interrupt_main_thread)

            def wait() -> None:
                timer.start()
                threading.Event().wait(30)  # on a busy machine the interrupt may come first

            with pytest.raises(WatchdogInterrupt):
                wait()
            timer.join()

    def test_watchdog_interrupt_after_the_mask_raises_nothing(self) -> None:
        with SignalGuard() as guard:
            guard.mask()
            signal.raise_signal(WATCHDOG_SIGNAL)
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
    before = f"signal.signal({number}, lambda *_: print('heard'))"
    assert (
        _status_of(
            f"import signal; from robotcore.runtime.signals import end_by_signal; {before}; end_by_signal({number})"
        )
        == -number
    )


def _status_of(code: str) -> int:
    return subprocess.run([sys.executable, "-c", code], check=False).returncode


@pytest.fixture
def interrupted() -> Iterator[Callable[[str, signal.Signals], tuple[int, dict[str, Any]]]]:
    """Return a function that ends a run in another process by a signal, and returns its exit status and result."""
    processes: list[subprocess.Popen[str]] = []

    def run(app: str, number: signal.Signals) -> tuple[int, dict[str, Any]]:
        command = [sys.executable, "-m", "tests.robotcore.runtime.interrupted_run", app]
        process = subprocess.Popen(command, cwd=RUN.parents[3], stdout=subprocess.PIPE, text=True)
        processes.append(process)
        assert process.stdout
        assert process.stdout.readline() == "moving\n"
        process.send_signal(number)
        result, _ = process.communicate(timeout=60)
        return process.returncode, json.loads(result.splitlines()[-1])

    yield run
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("app", ["ordinary", "hung", "waiting", "deaf"])
def test_signal_stops_the_motors_and_ends_the_run(
    interrupted: Callable[[str, signal.Signals], tuple[int, dict[str, Any]]], app: str, number: signal.Signals
) -> None:
    status, result = interrupted(app, number)
    assert status == 128 + number
    assert result["outcome"] == "interrupted"
    assert result["reason"] == f"interrupted by {number.name}"
    assert result["wheels"] == [0.0, 0.0]
    assert result["releases"] == [1, 1]


@pytest.mark.slow
@pytest.mark.parametrize("app", [["impervious"], ["beyond_python"], ["hung", "in_a_thread"]])
def test_process_of_an_app_that_never_returns_ends_after_stop_and_report(app: list[str]) -> None:
    command = [sys.executable, "-m", "tests.robotcore.runtime.interrupted_run", *app]
    ended = subprocess.run(command, cwd=RUN.parents[3], capture_output=True, text=True, timeout=60, check=False)
    moving, *_, observed, result = ended.stdout.splitlines()
    assert (moving, observed) == ("moving", "observed")
    assert ended.returncode == 4
    assert json.loads(result)["outcome"] == "stopped"
    assert json.loads(result)["wheels"] == [0.0, 0.0]
    assert f"in {app[0]}" in ended.stderr, "the lines of every thread"


@pytest.mark.slow
def test_third_signal_ends_the_process_after_stop_and_report() -> None:
    command = [sys.executable, "-m", "tests.robotcore.runtime.interrupted_run", "impervious"]
    with subprocess.Popen(command, cwd=RUN.parents[3], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        assert process.stdout.readline() == "moving\n"
        for _ in range(LAST_SIGNAL):
            assert process.stdout.readline() == "impervious\n"
            process.send_signal(signal.SIGTERM)
        observed, result = process.stdout.read().splitlines()
    assert process.returncode == -signal.SIGTERM
    assert observed == "observed"
    assert json.loads(result)["wheels"] == [0.0, 0.0]
    assert json.loads(result)["outcome"] == "interrupted"

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
    """Begin as a program does that was started from a terminal."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


class TestInterrupts:
    @pytest.mark.parametrize("number", SIGNALS)
    def test_a_signal_raises_where_the_program_is_whatever_it_catches(self, number: signal.Signals) -> None:
        with pytest.raises(Interrupted, match=number.name) as raised, SignalGuard(), suppress(Exception):
            signal.raise_signal(number)
        assert raised.value.exit_status == 128 + number

    def test_one_that_was_swallowed_is_raised_again_by_a_check(self) -> None:
        with SignalGuard() as interrupts:
            interrupts.check()
            with pytest.raises(Interrupted):
                signal.raise_signal(signal.SIGTERM)
            with pytest.raises(Interrupted, match="SIGTERM"):
                interrupts.check()

    def test_the_third_stops_the_motors_and_ends_the_process(self, monkeypatch: pytest.MonkeyPatch) -> None:
        ended: list[int | str] = []

        def die(number: int) -> None:
            ended.append(number)
            raise SystemExit

        def stop() -> None:
            signal.raise_signal(signal.SIGTERM)  # a fourth one cuts nothing short
            ended.append("stopped")

        monkeypatch.setattr("robotcore.runtime.signals.die_of", die)
        with SignalGuard() as interrupts:
            interrupts.stop_with(stop)
            for _ in range(2):
                with pytest.raises(Interrupted):
                    signal.raise_signal(signal.SIGTERM)
            assert not ended
            with pytest.raises(SystemExit):
                signal.raise_signal(signal.SIGTERM)
        assert ended == ["stopped", signal.SIGTERM]

    def test_one_that_is_put_off_raises_afterwards(self) -> None:
        done: list[str] = []

        def do_wholly(interrupts: SignalGuard) -> None:
            with interrupts.defer():
                signal.raise_signal(signal.SIGTERM)
                done.append("all")

        with SignalGuard() as interrupts, pytest.raises(Interrupted, match="SIGTERM"):
            do_wholly(interrupts)
        assert done == ["all"]

    def test_none_raises_while_it_is_held(self) -> None:
        with SignalGuard() as interrupts:
            interrupts.mask()
            signal.raise_signal(signal.SIGTERM)

    def test_handlers_are_put_back(self) -> None:
        before = [signal.getsignal(number) for number in SIGNALS]
        with SignalGuard():
            assert [signal.getsignal(number) for number in SIGNALS] != before
        assert [signal.getsignal(number) for number in SIGNALS] == before

    @pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGQUIT])
    def test_one_that_was_ignored_stays_ignored(self, number: signal.Signals) -> None:
        signal.signal(number, signal.SIG_IGN)
        with SignalGuard():
            signal.raise_signal(number)

    def test_a_recall_from_another_thread_interrupts_what_waits(self) -> None:
        with SignalGuard() as interrupts:
            timer = threading.Timer(0.05, interrupts.interrupt_main_thread)

            def wait() -> None:
                timer.start()
                threading.Event().wait(30)  # where the machine is busy, the call may come before

            with pytest.raises(WatchdogInterrupt):
                wait()
            timer.join()

    def test_a_recall_that_comes_too_late_raises_nothing(self) -> None:
        with SignalGuard() as interrupts:
            interrupts.mask()
            signal.raise_signal(WATCHDOG_SIGNAL)
            interrupts.interrupt_main_thread()

    def test_a_recall_that_nobody_hears_does_nothing(self) -> None:
        with SignalGuard():
            pass
        signal.raise_signal(WATCHDOG_SIGNAL)

    def test_outside_the_main_thread_it_leaves_signals_alone(self) -> None:
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
def test_a_process_dies_of_the_signal_whatever_was_done_about_it_before(number: signal.Signals) -> None:
    before = f"signal.signal({number}, lambda *_: print('heard'))"
    assert (
        _status_of(f"import signal; from robotcore.runtime.signals import die_of; {before}; die_of({number})")
        == -number
    )


def test_a_signal_that_is_blocked_is_named_by_the_exit_status() -> None:
    before = "signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])"
    assert _status_of(f"import signal; from robotcore.runtime.signals import die_of; {before}; die_of(15)") == 143


def _status_of(code: str) -> int:
    return subprocess.run([sys.executable, "-c", code], check=False).returncode


@pytest.fixture
def interrupted() -> Iterator[Callable[[str, signal.Signals], tuple[int, dict[str, Any]]]]:
    """Start a run in a process of its own, end it by a signal, and tell its exit status and what it printed."""
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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGQUIT])
@pytest.mark.parametrize("app", ["ordinary", "slow", "hung", "waiting", "swallowing", "deaf"])
def test_a_signal_stops_the_motors_and_ends_the_run(
    interrupted: Callable[[str, signal.Signals], tuple[int, dict[str, Any]]], app: str, number: signal.Signals
) -> None:
    status, result = interrupted(app, number)
    assert status == 128 + number
    assert result["outcome"] == "interrupted"
    assert result["reason"] == f"interrupted by {number.name}"
    assert result["wheels"] == [0.0, 0.0]
    assert result["releases"] == [1, 1]


@pytest.mark.parametrize("app", ["impervious", "beyond_python"])
def test_an_app_that_never_comes_back_ends_with_its_process_after_all_is_stopped_and_reported(app: str) -> None:
    command = [sys.executable, "-m", "tests.robotcore.runtime.interrupted_run", app]
    ended = subprocess.run(command, cwd=RUN.parents[3], capture_output=True, text=True, timeout=60, check=False)
    moving, *_, observed, result = ended.stdout.splitlines()
    assert (moving, observed) == ("moving", "observed")
    assert ended.returncode == 4
    assert json.loads(result)["reason"].startswith("App has not come back from step")
    assert json.loads(result)["wheels"] == [0.0, 0.0]


def test_the_third_signal_ends_the_process_when_all_is_stopped_and_reported() -> None:
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

"""The e-stop key of a terminal, on a real pty and in a job of a real session."""

from __future__ import annotations

import os
import signal
import sys
import termios
import tty
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from robotcore.cli import estop_key as keys
from robotcore.errors import Interrupted
from tests.robotcore.cli.conftest import AppFile
from tests.robotcore.cli.terminal import Terminal, read_end, wait_for
from tests.robotcore.cli.terminal import terminal as terminal  # noqa: PLC0414  a fixture

DRIVE = ("avoid-obstacles", "--realtime", "--set", "duration_s=60", "--world", "open")
HANGS = """
            from contextlib import suppress
            from threading import Event
            while True:
                with suppress(BaseException):
                    Event().wait()
"""
ASKS = """
            print("line read:", repr(input("go on? ")), flush=True)
            return Status.SUCCESS
"""
READS_TO_THE_END = ASKS.replace('input("go on? ")', "__import__('sys').stdin.read()")
IS_DEBUGGED = "breakpoint()\n            return Status.SUCCESS"

COUNTING = """
import os, select, sys, tty
from robotcore import Behaviour, Role, Status

class Counting(Behaviour):
    needs = frozenset({Role.DRIVE})

    keys = None

    def step(self, robot):
        if self.keys is None:
            tty.setcbreak(sys.stdin)
            self.keys = ""
            print("ready", flush=True)
        if select.select([sys.stdin], [], [], 0)[0]:
            self.keys += os.read(sys.stdin.fileno(), 1).decode()
        if len(self.keys) == 20:
            print("keys:", self.keys, flush=True)
            return Status.SUCCESS
        return Status.RUNNING
"""
"""An app that reads single keys, and ends after 20."""

TWENTY = b"abcdefghijklmnopqrst"

JUST_BEHIND = """
from robotcore.cli import estop_key, main
estop_key._is_in_foreground = lambda terminal: True
estop_key.EmergencyStopKey._set_cbreak_mode = lambda self: None
main.main()
"""
"""The program of a job that reads the terminal although it is in the background."""


@pytest.mark.slow
def test_the_space_bar_stops_the_run(terminal: Terminal) -> None:
    terminal.run(*DRIVE)
    wait_for(lambda: terminal.is_raw)
    wait_for(lambda: b"space: stop" in terminal.output)
    terminal.type(b"x ")
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == ("stopped", "exited 4")
    assert answer["kind"] == "emergency-stop"
    assert terminal.is_restored


@pytest.mark.slow
def test_other_keys_do_nothing_and_ctrl_c_still_interrupts(terminal: Terminal) -> None:
    terminal.run(*DRIVE)
    wait_for(lambda: terminal.is_raw)
    terminal.type(b"stop!\n")
    terminal.type(b"\x03")
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == ("interrupted", "exited -2")
    assert terminal.is_restored


@pytest.mark.slow
def test_a_process_that_ends_itself_restores_the_terminal(terminal: Terminal, app_file: AppFile) -> None:
    terminal.run(app_file(HANGS))
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == ("stopped", "exited 4")
    assert terminal.is_restored


@pytest.mark.slow
@pytest.mark.parametrize(
    "step, options, prompt, typed, shown",
    [
        (ASKS, [], b"go on?", b"yess\x7f\n", [b"line read: 'yes'", b"yess"]),
        (ASKS, ["--no-estop-key"], b"go on?", b"  \n", [b"line read: '  '"]),
        (READS_TO_THE_END, ["--realtime"], b"space: stop", b"yes\n\x04", [rb"line read: 'yes\n'"]),
        (IS_DEBUGGED, [], b"(Pdb)", b"p 6 * 7\ncontinue\n", [b"42"]),
    ],
    ids=["line and its echo", "without the key", "to its end", "debugger"],
)
def test_an_app_can_read_from_the_terminal(
    terminal: Terminal,
    app_file: AppFile,
    step: str,
    options: list[str],
    prompt: bytes,
    typed: bytes,
    shown: list[bytes],
) -> None:
    terminal.run(app_file(step), *options)
    wait_for(lambda: prompt in terminal.output)
    is_key = "--no-estop-key" not in options
    assert is_key or terminal.is_restored
    terminal.type(typed)
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == ("success", "exited 0")
    assert all(each in terminal.output for each in shown)
    assert is_key or b"space: stop" not in terminal.output
    assert terminal.is_restored


@pytest.mark.slow
@pytest.mark.parametrize(
    "options, typed, outcome, status",
    [
        ([], TWENTY, "success", 0),
        (["--no-estop-key"], b" " + TWENTY[1:], "success", 0),
        ([], b"abc def", "stopped", 4),
    ],
    ids=["other keys", "without the key", "space bar"],
)
def test_an_app_gets_each_key_at_once_and_the_space_bar_stops_its_run(
    terminal: Terminal, tmp_path: Path, options: list[str], typed: bytes, outcome: str, status: int
) -> None:
    app = tmp_path / "counting.py"
    app.write_text(COUNTING)
    terminal.run(str(app), "--realtime", *options)
    wait_for(lambda: b"ready" in terminal.output)
    for key in typed:
        terminal.type(bytes([key]))
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == (outcome, f"exited {status}")
    assert status or b"keys: " + typed in terminal.output
    assert status == 0 or terminal.is_restored


@pytest.mark.slow
def test_a_suspended_run_restores_the_terminal_until_it_continues(terminal: Terminal) -> None:
    terminal.run(*DRIVE)
    wait_for(lambda: terminal.is_raw)
    terminal.type(b"\x1a")
    assert terminal.read_line() == "stopped"
    assert terminal.is_restored
    terminal.resume()
    wait_for(lambda: terminal.is_raw)
    terminal.type(b" ")
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == ("stopped", "exited 4")
    assert terminal.is_restored


@pytest.mark.slow
@pytest.mark.parametrize("program", [("-m", "robotcore"), ("-c", JUST_BEHIND)], ids=["background", "just behind"])
def test_keys_do_not_stop_a_run_in_the_background_and_its_terminal_stays(
    terminal: Terminal, program: tuple[str, str]
) -> None:
    drive = ("avoid-obstacles", "--realtime", "--timeout", "2", "--world", "open")
    terminal.run(*drive, place="background", program=program)
    terminal.type(b"  \n")
    answer, exited = read_end(terminal)
    assert (answer["outcome"], exited) == ("timeout", "exited 1")
    assert terminal.is_restored


@pytest.fixture
def bar(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> Iterator[keys.EmergencyStopKey]:
    """Create an e-stop key in this process, which counts as a foreground process."""
    with os.fdopen(os.dup(terminal.slave)) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        monkeypatch.setattr(keys, "_is_in_foreground", lambda _: True)
        yield keys.EmergencyStopKey()


def test_a_paused_key_does_not_change_the_terminal(terminal: Terminal, bar: keys.EmergencyStopKey) -> None:
    terminal.type(b" ")  # so that the read does not wait
    bar.pause()
    bar._read_keys(terminal.slave, [terminal.slave])
    assert terminal.is_restored
    bar.resume()
    assert terminal.is_raw
    bar.close()
    bar.resume()
    assert terminal.is_restored


def test_the_hint_is_shown_only_while_the_key_works(
    bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not bar.get_hint()
    bar.resume()
    assert bar.get_hint() == "space: stop"
    monkeypatch.setattr(keys, "_is_in_foreground", lambda _: False)
    assert not bar.get_hint()
    monkeypatch.setattr(keys, "_is_in_foreground", lambda _: True)
    bar.pause()
    assert not bar.get_hint()


@pytest.mark.parametrize("is_set", [True, False], ids=["mode set", "mode restored"])
def test_the_terminal_is_restored_after_an_interrupt_while_its_mode_changes(
    terminal: Terminal, bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch, *, is_set: bool
) -> None:
    set_mode = termios.tcsetattr

    def be_interrupted(*arguments: Any) -> None:
        if is_set:
            set_mode(*arguments)
        raise Interrupted(signal.SIGINT)

    if not is_set:
        bar.resume()
    with monkeypatch.context() as patch:
        patch.setattr(tty if is_set else termios, "tcsetattr", be_interrupted)
        with pytest.raises(Interrupted):
            (bar.resume if is_set else bar.close)()
    assert terminal.is_raw
    bar.close()
    assert terminal.is_restored


def test_without_a_terminal_there_is_no_key(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path(os.devnull).open() as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        assert not keys.can_listen()
    assert not keys.can_listen()
    monkeypatch.setattr(sys, "stdin", None)
    assert not keys.can_listen()


@pytest.mark.parametrize("failure", [None, OSError("out of pseudo-terminals")])
def test_the_space_bar_presses_the_emergency_stop_even_without_a_pseudo_terminal(
    terminal: Terminal, bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch, failure: OSError | None
) -> None:
    if failure:
        monkeypatch.setattr(keys, "AppTerminal", Mock(side_effect=failure))
    run = Mock()
    bar.begin(run)
    terminal.type(b" ")
    wait_for(lambda: run.emergency.press.called)
    assert bar.get_hint()
    bar.close()
    assert terminal.is_restored


def test_a_terminal_that_cannot_be_opened_is_left_to_the_app(
    terminal: Terminal, bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: int) -> str:
        raise OSError

    monkeypatch.setattr(os, "ttyname", fail)
    bar.begin(None)  # type: ignore[arg-type]
    bar.resume()
    assert terminal.is_restored
    assert not bar.get_hint()

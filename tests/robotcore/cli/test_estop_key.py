"""The e-stop in a terminal: on a real pty, in a job of a real session."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import termios
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from robotcore.cli import estop_key as keys
from robotcore.errors import Interrupted

ROOT = Path(__file__).parents[3]
DRIVE = ("avoid-obstacles", "--realtime", "--set", "duration_s=60", "--world", "open")
PATIENCE_S = 60.0
IMPERVIOUS = """
from contextlib import suppress
from threading import Event
from robotcore import Behaviour, Role, Status

class Impervious(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        while robot.clock.now() > 0.5:
            with suppress(BaseException):
                Event().wait()
        return Status.RUNNING
"""

READING = """
from robotcore import Behaviour, Role, Status

class Reading(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        if robot.clock.now() > 0.5:
            print("heard", repr(input("go on? ")), flush=True)
            return Status.SUCCESS
        return Status.RUNNING
"""

DEBUGGED = READING.replace('print("heard", repr(input("go on? ")), flush=True)', "breakpoint()")

JUST_BEHIND = """
from robotcore.cli import estop_key, main
estop_key._is_in_foreground = lambda terminal: True
estop_key.EmergencyStopKey._take = lambda self: None
main.main()
"""
"""A job that has just gone behind, and has not noticed."""


class Terminal:
    """A terminal, and a shell in it that runs one job."""

    def __init__(self) -> None:
        self.master, self.slave = os.openpty()
        self.before = termios.tcgetattr(self.slave)
        self._control, self._resume = os.pipe()
        self._shell: subprocess.Popen[str] | None = None
        self.shown = b""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def run(self, *arguments: str, place: str = "front", program: tuple[str, str] = ("-m", "robotcore")) -> None:
        command = [sys.executable, "-m", "tests.robotcore.cli.shell", place]
        job = [sys.executable, *program, "run", *arguments, "--json"]
        self._shell = subprocess.Popen(
            [*command, *job],
            cwd=ROOT,
            stdin=self.slave,
            stdout=subprocess.PIPE,
            stderr=self.slave,
            text=True,
            start_new_session=True,
            pass_fds=[self._control],
            env={**os.environ, "CONTROL": str(self._control)},
        )

    def type(self, key: bytes) -> None:
        os.write(self.master, key)

    def resume(self) -> None:
        os.write(self._resume, b"!")

    def hear(self) -> str:
        assert self._shell
        assert self._shell.stdout
        return self._shell.stdout.readline().strip()

    @property
    def is_raw(self) -> bool:
        """Whether keys come at once."""
        return not termios.tcgetattr(self.slave)[3] & termios.ICANON

    @property
    def is_as_it_was(self) -> bool:
        return termios.tcgetattr(self.slave) == self.before

    def close(self) -> None:
        if self._shell:
            self._shell.kill()  # and the job in front is hung up
            self._shell.communicate()
        os.close(self.slave)
        self._reader.join(PATIENCE_S)
        for each in (self.master, self._control, self._resume):
            os.close(each)

    def _read(self) -> None:
        with suppress(OSError):
            while shown := os.read(self.master, 4096):
                self.shown += shown


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    each = Terminal()
    yield each
    each.close()


def wait_for(is_so: Callable[[], bool]) -> None:
    patience = threading.Event()
    for _ in range(round(PATIENCE_S / 0.02)):
        if is_so():
            return
        patience.wait(0.02)
    pytest.fail("it has not come to that")


def answered(terminal: Terminal) -> bool:
    """Type a line, since the listener may have read the one before; return whether the app has read one."""
    terminal.type(b"\n")
    return b"heard" in terminal.shown


def ended(terminal: Terminal) -> tuple[dict[str, Any], str]:
    """Return what the job told, and how it exited."""
    return json.loads(terminal.hear()), terminal.hear()


def test_the_space_bar_stops_the_run(terminal: Terminal) -> None:
    terminal.run(*DRIVE)
    wait_for(lambda: terminal.is_raw)
    wait_for(lambda: b"space: stop" in terminal.shown)
    terminal.type(b"x ")
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("stopped", "exited 4")
    assert answer["reason"] == "e-stop: the space bar was pressed in the terminal"
    assert terminal.is_as_it_was


def test_other_keys_do_nothing_and_ctrl_c_is_what_it_was(terminal: Terminal) -> None:
    terminal.run(*DRIVE)
    wait_for(lambda: terminal.is_raw)
    terminal.type(b"stop!\n")
    terminal.type(b"\x03")
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("interrupted", "exited -2")
    assert terminal.is_as_it_was


def test_the_terminal_is_put_back_by_a_process_that_ends_itself(terminal: Terminal, tmp_path: Path) -> None:
    app = tmp_path / "impervious.py"
    app.write_text(IMPERVIOUS)
    terminal.run(str(app))
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("stopped", "exited 4")
    assert terminal.is_as_it_was


def test_an_app_that_reads_the_terminal_gets_what_it_reads_and_the_run_ends(terminal: Terminal, tmp_path: Path) -> None:
    app = tmp_path / "reading.py"
    app.write_text(READING)
    terminal.run(str(app))
    wait_for(lambda: b"go on?" in terminal.shown)
    wait_for(lambda: answered(terminal))
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("success", "exited 0")
    assert terminal.is_as_it_was


def test_a_debugger_has_the_terminal_to_itself(terminal: Terminal, tmp_path: Path) -> None:
    app = tmp_path / "debugged.py"
    app.write_text(DEBUGGED)
    terminal.run(str(app))
    wait_for(lambda: b"(Pdb)" in terminal.shown)
    wait_for(lambda: terminal.is_as_it_was)
    terminal.type(b"p 6 * 7\n")
    wait_for(lambda: b"42" in terminal.shown)
    terminal.type(b"continue\n")
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("success", "exited 0")
    assert terminal.is_as_it_was


def test_suspended_it_leaves_the_terminal_to_the_shell_and_takes_it_again(terminal: Terminal) -> None:
    terminal.run(*DRIVE)
    wait_for(lambda: terminal.is_raw)
    terminal.type(b"\x1a")
    assert terminal.hear() == "stopped"
    assert terminal.is_as_it_was
    terminal.resume()
    wait_for(lambda: terminal.is_raw)
    terminal.type(b" ")
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("stopped", "exited 4")
    assert terminal.is_as_it_was


def test_in_the_background_it_leaves_the_terminal_alone(terminal: Terminal) -> None:
    terminal.run("avoid-obstacles", "--realtime", "--timeout", "1", place="behind")
    terminal.type(b"  \n")
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("timeout", "exited 1")
    assert terminal.is_as_it_was


def test_what_is_typed_just_after_it_went_behind_stops_no_job_that_drives(terminal: Terminal) -> None:
    drive = ("avoid-obstacles", "--realtime", "--timeout", "2", "--world", "open")
    terminal.run(*drive, place="behind", program=("-c", JUST_BEHIND))
    terminal.type(b"  \n")
    answer, exited = ended(terminal)
    assert (answer["outcome"], exited) == ("timeout", "exited 1")


@pytest.fixture
def bar(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> Iterator[keys.EmergencyStopKey]:
    """A space bar in this process, which is in front of the terminal."""
    with os.fdopen(os.dup(terminal.slave)) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        monkeypatch.setattr(keys, "_is_in_foreground", lambda _: True)
        yield keys.EmergencyStopKey()


def test_paused_it_leaves_the_terminal_alone_though_it_still_listens(
    terminal: Terminal, bar: keys.EmergencyStopKey
) -> None:
    terminal.type(b" ")  # so that it need not wait
    bar.pause()
    with keys._open_keys(terminal.slave) as there:
        bar._read_keys(there)
    assert terminal.is_as_it_was
    bar.resume()
    assert terminal.is_raw
    bar.close()
    bar.resume()
    assert terminal.is_as_it_was


def test_the_key_is_offered_only_while_the_terminal_is_ours(
    bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not bar.hint()
    bar.resume()
    assert bar.hint() == "space: stop"
    monkeypatch.setattr(keys, "_is_in_foreground", lambda _: False)
    assert not bar.hint()
    monkeypatch.setattr(keys, "_is_in_foreground", lambda _: True)
    bar.pause()
    assert not bar.hint()


def test_an_interrupt_just_after_the_terminal_was_taken_leaves_it_as_it_was(
    terminal: Terminal, bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch
) -> None:
    def take_and_be_interrupted(*answer: Any) -> None:
        termios.tcsetattr(*answer)
        raise Interrupted(signal.SIGINT)

    monkeypatch.setattr(tty, "tcsetattr", take_and_be_interrupted)
    with pytest.raises(Interrupted):
        bar.resume()
    assert terminal.is_raw
    bar.close()
    assert terminal.is_as_it_was


def test_an_interrupt_just_before_the_terminal_is_put_back_leaves_it_as_it_was(
    terminal: Terminal, bar: keys.EmergencyStopKey, monkeypatch: pytest.MonkeyPatch
) -> None:
    def be_interrupted(*answer: Any) -> None:
        raise Interrupted(signal.SIGINT)

    bar.resume()
    with monkeypatch.context() as patch:
        patch.setattr(termios, "tcsetattr", be_interrupted)
        with pytest.raises(Interrupted):
            bar.close()
    assert terminal.is_raw
    bar.close()
    assert terminal.is_as_it_was


def test_where_standard_input_is_no_terminal_nobody_can_press(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path(os.devnull).open() as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        assert not keys.can_listen()
    assert not keys.can_listen()
    monkeypatch.setattr(sys, "stdin", None)
    assert not keys.can_listen()

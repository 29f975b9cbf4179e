"""A terminal with a shell that runs one job, on a real pty."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

try:
    import termios
except ModuleNotFoundError:
    pytest.skip("a pseudo-terminal needs POSIX", allow_module_level=True)

ROOT = Path(__file__).parents[3]
LIMIT_S = 60.0


class Terminal:
    """A terminal with a shell that runs one job."""

    def __init__(self) -> None:
        self.master, self.slave = os.openpty()
        self.before = termios.tcgetattr(self.slave)
        self._control, self._resume = os.pipe()
        self._shell: subprocess.Popen[str] | None = None
        self.output = b""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def run(
        self,
        *arguments: str,
        place: str = "foreground",
        program: tuple[str, str] = ("-m", "robotcore"),
        command: str = "run",
    ) -> None:
        shell = [sys.executable, "-m", "tests.robotcore.cli.shell", place]
        job = [sys.executable, *program, command, *arguments, "--json"]
        self._shell = subprocess.Popen(
            [*shell, *job],
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

    def hang_up(self) -> None:
        """End the session of the terminal. The job in the foreground gets SIGHUP."""
        assert self._shell
        self._shell.kill()

    def read_line(self) -> str:
        assert self._shell
        assert self._shell.stdout
        return self._shell.stdout.readline().strip()

    @property
    def is_raw(self) -> bool:
        """Whether keys are read at once."""
        return not termios.tcgetattr(self.slave)[3] & termios.ICANON

    @property
    def is_restored(self) -> bool:
        return termios.tcgetattr(self.slave) == self.before

    def close(self) -> None:
        if self._shell:
            self._shell.kill()  # the job in the foreground gets SIGHUP
            self._shell.communicate()
        os.close(self.slave)
        self._reader.join(LIMIT_S)
        for each in (self.master, self._control, self._resume):
            os.close(each)

    def _read(self) -> None:
        with suppress(OSError):
            while chunk := os.read(self.master, 4096):
                self.output += chunk


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    each = Terminal()
    yield each
    each.close()


def wait_for(condition: Callable[[], bool]) -> None:
    timer = threading.Event()
    for _ in range(round(LIMIT_S / 0.02)):
        if condition():
            return
        timer.wait(0.02)
    pytest.fail(f"the condition was not met within {LIMIT_S:g} s")


def read_end(terminal: Terminal) -> tuple[dict[str, Any], str]:
    """Return the job's JSON, and the line with its exit status."""
    return json.loads(terminal.read_line()), terminal.read_line()

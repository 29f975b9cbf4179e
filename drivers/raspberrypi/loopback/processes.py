"""Starts the programs of the loopback test, and reads their events. No program outlives its context."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from queue import Empty, SimpleQueue
from subprocess import DEVNULL
from typing import Any, ClassVar

from drivers.raspberrypi.loopback.motor_program import MotorProgramRequest
from robotcore.child_process import build_session_options
from robotcore.threads import start_thread

START_S = 60.0
"""The time limit for the start of a program, in seconds. A Pi Zero takes long to import NumPy."""

END_S = 15.0

CODE = "import sys; sys.path[:] = sys.argv[2:]; from drivers.raspberrypi.loopback.motor_program import main; main()"
"""The code of the motor program. With ``python -m``, Python would import a json.py of the working folder."""

LOAD = """
import os, sys
while os.getppid() == int(sys.argv[1]):
    sum(range(50_000))
"""
"""A program that uses a processor until its parent ends."""


class LoopbackProgram:
    """A running program of the test. The process runs from its construction until `end`."""

    command: ClassVar[list[str]] = [sys.executable, "-c", CODE]

    def __init__(self, request: MotorProgramRequest) -> None:
        self._process = subprocess.Popen(  # noqa: S603  our own
            [*self.command, json.dumps(asdict(request)), *sys.path],
            stdin=DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        self._lines: SimpleQueue[str | None] = SimpleQueue()
        self._errors: list[str] = []
        try:
            self._readers = [
                start_thread(self._read_events, "loopback events"),
                start_thread(self._read_errors, "loopback errors"),
            ]
        except BaseException:
            self._process.kill()
            self._process.wait()
            raise

    def _read_events(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put(None)

    def _read_errors(self) -> None:
        assert self._process.stderr
        self._errors += self._process.stderr

    def await_event(self, name: str, timeout_s: float = START_S) -> dict[str, Any] | None:
        """Return the next event with a name; None if the program ends first or the time limit passes."""
        while True:
            try:
                line = self._lines.get(timeout=timeout_s)
            except Empty:
                return None
            if line is None:
                self._lines.put(None)
                return None
            with suppress(ValueError):
                event = json.loads(line)
                if isinstance(event, dict) and event.get("event") == name:
                    return event

    def send_signal(self, signal_number: int) -> None:
        """Send a signal."""
        self._process.send_signal(signal_number)

    @property
    def is_running(self) -> bool:
        """Whether the program has not ended yet."""
        return self._process.poll() is None

    def describe_failure(self) -> str:
        """Return the last line that the program wrote on standard error, after its end."""
        self.end()
        lines = [line.strip() for line in self._errors if line.strip()]
        return lines[-1] if lines else f"the program ended with status {self._process.returncode}"

    def end(self) -> None:
        """End the program: by SIGTERM, and after a time by SIGKILL. Its guardian then stops the motor."""
        if self._process.poll() is None:
            self.send_signal(signal.SIGTERM)
        try:
            self._process.wait(END_S)
        except BaseException as error:  # a second signal must not leave the program running
            self._process.kill()
            self._process.wait()
            if not isinstance(error, subprocess.TimeoutExpired):
                raise
        for reader, pipe in zip(self._readers, (self._process.stdout, self._process.stderr), strict=True):
            reader.join(END_S)  # the guardian holds standard error open until it has stopped the motor
            if pipe and not reader.is_alive():
                pipe.close()


@contextmanager
def run_program(request: MotorProgramRequest) -> Iterator[LoopbackProgram]:
    """Run a program during the block."""
    program = LoopbackProgram(request)
    try:
        yield program
    finally:
        program.end()


@contextmanager
def load_processors() -> Iterator[int]:
    """Keep every processor busy during the block. Yield the number of programs."""
    count = len(os.sched_getaffinity(0))
    command = [sys.executable, "-S", "-c", LOAD, str(os.getpid())]
    programs: list[subprocess.Popen[bytes]] = []
    try:
        for _ in range(count):
            program = subprocess.Popen(  # noqa: S603  our own
                command, stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL, **build_session_options()
            )
            programs.append(program)
        yield count
    finally:
        for program in programs:
            program.kill()
        for program in programs:
            program.wait()

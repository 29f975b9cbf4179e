"""A board with its robot, simulated: a process of its own, whose line is a pty and whose time is the AVR's."""

from __future__ import annotations

import math
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import NamedTuple

from robotcore.hal.wall_clock import MonotonicClock
from tests.system.firmware.simulated import HZ, MEMORY, SimulatedRobot, Wiring, made
from tests.system.speed import scaled

STANDS = "0.0000 0.0000"
"""What more is told of `duty` where neither motor is given any."""

LOOK_S = 0.002
HUNG_S = 300.0
"""On the reference machine: what is waited for has come by then, or is too late by the AVR's time."""


class Event(NamedTuple):
    """What happened (duty, line, plugged, pulled, reset, hangs, watchdog), at which of the AVR's times, in seconds."""

    time: float
    what: str
    more: str


class Board(SimulatedRobot):
    """Runs a sketch. Switched on by its constructor, which returns when the line can be opened at ``port``."""

    def __init__(self, simulator: Path, sketch: Path, wiring: Wiring) -> None:
        self._made = TemporaryDirectory(prefix="robotcore-avr-")
        folder = Path(self._made.name)
        super().__init__(folder, made(folder))
        wiring.build(self._bench)
        self.ask_until(math.inf)
        self.put_ahead(math.inf)
        self.charge(7.4)
        self._events: list[Event] = []
        self._process = subprocess.Popen(
            [simulator, sketch, self.port, folder / MEMORY], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._hearing = threading.Thread(target=self._hear, name="simulated board", daemon=True)
        self._hearing.start()
        self.wait(lambda: bool(self._heard("plugged")), "the line to be plugged in")

    def events(self, what: str = "", since: float = 0.0) -> list[Event]:
        """Return all that has happened since then until now, in order; of one kind, or all."""
        self._do("mark", "mark")
        return [event for event in self._heard(what) if event.time >= since]

    def pull(self) -> None:
        """Pull the line out: whoever has it open finds the other end gone, and the port is no more."""
        self._do("pull", "pulled")

    def plug(self) -> None:
        """Put the line back: the port is there again, though it leads to another pty."""
        self._do("plug", "plugged")

    def reset(self) -> None:
        """Press the reset button."""
        self._do("reset", "reset")

    def hang(self) -> None:
        """Let the sketch hang where it is, until something resets it; interrupts are served if they were on."""
        self._do("hang", "hangs")

    def pass_time(self, seconds: float) -> None:
        """Let so much of the AVR's time pass."""
        end = self.now() + seconds
        self.wait(lambda: self.now() >= end, f"{seconds:g} s to pass")

    def wait(self, is_so: Callable[[], bool], what: str, within_s: float = math.inf) -> None:
        """Wait until something is so; raises AssertionError where it is not within so much of the AVR's time."""
        wall, end, hung = MonotonicClock(), self.now() + within_s, scaled(HUNG_S)
        while not is_so():
            assert self._process.poll() is None, f"the simulator has ended with {self._process.returncode}"
            assert self.now() < end, f"waited {within_s:g} s of the AVR's time for {what}"
            assert wall.now() < hung, f"waited {hung:g} s for {what}, at {self.now():.3f} s of the AVR's time"
            wall.sleep_until(wall.now() + LOOK_S)

    def wait_for_stop(self, within_s: float) -> Event:
        """Wait until neither motor is given any duty, and return when that was."""
        self.wait(lambda: self.duties == (0.0, 0.0), "the wheels to be stopped", within_s)
        stopped = self.events("duty")[-1]
        assert stopped.more == STANDS, f"they turn again: {stopped}"
        return stopped

    def close(self) -> None:
        """Switch it off. May be called again."""
        if self._process.stdin and not self._process.stdin.closed:
            self._process.stdin.close()
            self._process.wait(scaled(HUNG_S))
            self._hearing.join()
            self._made.cleanup()

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _heard(self, what: str) -> list[Event]:
        return [event for event in list(self._events) if what in ("", event.what)]

    def _do(self, word: str, event: str) -> None:
        """Tell the simulator a word, and wait until it has told that it was done."""
        assert self._process.stdin
        before = len(self._heard(event))
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()
        self.wait(lambda: len(self._heard(event)) > before, word)

    def _hear(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                cycles, what, more = (line.rstrip("\n") + " ").split(" ", 2)
                self._events.append(Event(int(cycles) / HZ, what, more.rstrip()))

"""A simulated board with its robot: a process with a pty for the line, in the AVR's time."""

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
"""The text of a `duty` event if both duties are 0."""

LOOK_S = 0.002
HUNG_S = 300.0
"""The longest wait in real time, on the reference machine."""


class Event(NamedTuple):
    """An event (duty, line, plugged, pulled, reset, hangs, watchdog) and its time on the AVR in seconds."""

    time: float
    what: str
    more: str


class Board(SimulatedRobot):
    """Runs a sketch. The constructor returns when the line can be opened at ``port``."""

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
        """Return the events since a time, in order; of one kind, or all."""
        self._do("mark", "mark")
        return [event for event in self._heard(what) if event.time >= since]

    def pull(self) -> None:
        """Unplug the line: a process that has it open gets a hang-up, and the port is removed."""
        self._do("pull", "pulled")

    def plug(self) -> None:
        """Plug the line in again: the port leads to another pty."""
        self._do("plug", "plugged")

    def reset(self) -> None:
        """Press the reset button."""
        self._do("reset", "reset")

    def hang(self) -> None:
        """Let the sketch hang until a reset; interrupts are served if they were on."""
        self._do("hang", "hangs")

    def pass_time(self, seconds: float) -> None:
        """Let some seconds pass on the AVR."""
        end = self.now() + seconds
        self.wait(lambda: self.now() >= end, f"{seconds:g} s to pass")

    def wait(self, is_so: Callable[[], bool], what: str, within_s: float = math.inf) -> None:
        """Wait until a condition is true; raises AssertionError if it is not within these seconds on the AVR."""
        wall, end, hung = MonotonicClock(), self.now() + within_s, scaled(HUNG_S)
        while not is_so():
            assert self._process.poll() is None, f"the simulator has ended with {self._process.returncode}"
            assert self.now() < end, f"waited {within_s:g} s of the AVR's time for {what}"
            assert wall.now() < hung, f"waited {hung:g} s for {what}, at {self.now():.3f} s of the AVR's time"
            wall.sleep_until(wall.now() + LOOK_S)

    def wait_for_stop(self, within_s: float) -> Event:
        """Wait until both duties are 0, and return the time of that."""
        self.wait(lambda: self.duties == (0.0, 0.0), "the wheels to be stopped", within_s)
        stopped = self.events("duty")[-1]
        assert stopped.more == STANDS, f"they turn again: {stopped}"
        return stopped

    def close(self) -> None:
        """Switch the board off. May be called again."""
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
        """Send a command to the simulator, and wait until it is done."""
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

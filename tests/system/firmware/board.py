"""A simulated board with its robot: a process, with a pty as the board's line."""

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
from tests.system.firmware.simulated import HZ, MEMORY, SimulatedRobot, Wiring, create_bench
from tests.system.speed import scaled

STANDS = "0.0000 0.0000"
"""The text of a `duty` event if both duties are 0."""

POLL_S = 0.002
HUNG_S = 300.0
"""The longest wait in real time, in seconds on the reference machine."""


class Event(NamedTuple):
    """An event of the simulator, and its time in seconds of the AVR's time.

    what: duty, line, plugged, pulled, reset, hangs or watchdog.
    more: the data of the event, such as both duties, or the text of a line.
    """

    time: float
    what: str
    more: str


class Board(SimulatedRobot):
    """A board that runs a sketch. The constructor returns when ``port`` can be opened."""

    def __init__(self, simulator: Path, sketch: Path, wiring: Wiring) -> None:
        self._temporary = TemporaryDirectory(prefix="robotcore-avr-")
        folder = Path(self._temporary.name)
        super().__init__(folder, create_bench(folder))
        wiring.build(self._bench)
        self.run_until(math.inf)
        self.place_target(math.inf)
        self.set_battery_voltage(7.4)
        self._events: list[Event] = []
        self._process = subprocess.Popen(
            [simulator, sketch, self.port, folder / MEMORY], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._reader = threading.Thread(target=self._read_events, name="simulated board", daemon=True)
        self._reader.start()
        self.wait(lambda: bool(self._find_events("plugged")), "the line to be plugged in")

    def events(self, what: str = "", since: float = 0.0) -> list[Event]:
        """Return the events since a time, in order.

        what: the kind of the events to return; empty returns all.
        """
        self._command("mark", "mark")
        return [event for event in self._find_events(what) if event.time >= since]

    def pull(self) -> None:
        """Unplug the line. A process that has the port open gets a hang-up, and the port is removed."""
        self._command("pull", "pulled")

    def plug(self) -> None:
        """Plug the line in again. The port then leads to another pty."""
        self._command("plug", "plugged")

    def reset(self) -> None:
        """Press the reset button."""
        self._command("reset", "reset")

    def hang(self) -> None:
        """Let the sketch hang until a reset. Enabled interrupts are still served."""
        self._command("hang", "hangs")

    def pass_time(self, seconds: float) -> None:
        """Wait until ``seconds`` of the AVR's time have passed."""
        end = self.now() + seconds
        self.wait(lambda: self.now() >= end, f"{seconds:g} s to pass")

    def wait(self, is_true: Callable[[], bool], what: str, within_s: float = math.inf) -> None:
        """Wait until a condition is true; raises AssertionError after ``within_s`` seconds of the AVR's time.

        what: the condition in words, for the error.
        """
        wall, end, hung = MonotonicClock(), self.now() + within_s, scaled(HUNG_S)
        while not is_true():
            assert self._process.poll() is None, f"the simulator has ended with {self._process.returncode}"
            assert self.now() < end, f"waited {within_s:g} s of the AVR's time for {what}"
            assert wall.now() < hung, f"waited {hung:g} s for {what}, at {self.now():.3f} s of the AVR's time"
            wall.sleep_until(wall.now() + POLL_S)

    def wait_for_stop(self, within_s: float) -> Event:
        """Wait until both duties are 0, and return the event."""
        self.wait(lambda: self.duties == (0.0, 0.0), "the wheels to be stopped", within_s)
        stopped = self.events("duty")[-1]
        assert stopped.more == STANDS, f"the wheels turn again: {stopped}"
        return stopped

    def close(self) -> None:
        """Switch the board off. May be called again."""
        if self._process.stdin and not self._process.stdin.closed:
            self._process.stdin.close()
            self._process.wait(scaled(HUNG_S))
            self._reader.join()
            self._temporary.cleanup()

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _find_events(self, what: str) -> list[Event]:
        return [event for event in list(self._events) if what in ("", event.what)]

    def _command(self, word: str, event: str) -> None:
        """Send a command to the simulator, and wait for the event that confirms it."""
        assert self._process.stdin
        before = len(self._find_events(event))
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()
        self.wait(lambda: len(self._find_events(event)) > before, word)

    def _read_events(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                cycles, what, more = (line.rstrip("\n") + " ").split(" ", 2)
                self._events.append(Event(int(cycles) / HZ, what, more.rstrip()))

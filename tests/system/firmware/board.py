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
from tests.system.firmware.simulated import HZ, MEMORY, SimulatedRobot, Wiring, create_bench
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
        super().__init__(folder, create_bench(folder))
        wiring.build(self._bench)
        self.ask_until(math.inf)
        self.put_ahead(math.inf)
        self.charge(7.4)
        self._events: list[Event] = []
        self._process = subprocess.Popen(
            [simulator, sketch, self.port, folder / MEMORY], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._reader = threading.Thread(target=self._read_events, name="simulated board", daemon=True)
        self._reader.start()
        self.wait(lambda: bool(self._find_events("plugged")), "the line to be plugged in")

    def events(self, what: str = "", since: float = 0.0) -> list[Event]:
        """Return the events since a time, in order; of one kind, or all."""
        self._do("mark", "mark")
        return [event for event in self._find_events(what) if event.time >= since]

    def pull(self) -> None:
        """Unplug the line. A process that has it open gets a hang-up, and the port is removed."""
        self._do("pull", "pulled")

    def plug(self) -> None:
        """Plug the line in again. The port then leads to another pty."""
        self._do("plug", "plugged")

    def reset(self) -> None:
        """Press the reset button."""
        self._do("reset", "reset")

    def hang(self) -> None:
        """Let the sketch hang until a reset. Enabled interrupts are still served."""
        self._do("hang", "hangs")

    def pass_time(self, seconds: float) -> None:
        """Let some seconds pass on the AVR."""
        end = self.now() + seconds
        self.wait(lambda: self.now() >= end, f"{seconds:g} s to pass")

    def wait(self, is_true: Callable[[], bool], what: str, within_s: float = math.inf) -> None:
        """Wait until a condition is true; raises AssertionError after these seconds on the AVR."""
        wall, end, hung = MonotonicClock(), self.now() + within_s, scaled(HUNG_S)
        while not is_true():
            assert self._process.poll() is None, f"the simulator has ended with {self._process.returncode}"
            assert self.now() < end, f"waited {within_s:g} s of the AVR's time for {what}"
            assert wall.now() < hung, f"waited {hung:g} s for {what}, at {self.now():.3f} s of the AVR's time"
            wall.sleep_until(wall.now() + LOOK_S)

    def wait_for_stop(self, within_s: float) -> Event:
        """Wait until both duties are 0. Return the event."""
        self.wait(lambda: self.duties == (0.0, 0.0), "the wheels to be stopped", within_s)
        stopped = self.events("duty")[-1]
        assert stopped.more == STANDS, f"the wheels turn again: {stopped}"
        return stopped

    def close(self) -> None:
        """Switch the board off. It may be called again."""
        if self._process.stdin and not self._process.stdin.closed:
            self._process.stdin.close()
            self._process.wait(scaled(HUNG_S))
            self._reader.join()
            self._made.cleanup()

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _find_events(self, what: str) -> list[Event]:
        return [event for event in list(self._events) if what in ("", event.what)]

    def _do(self, word: str, event: str) -> None:
        """Send a command to the simulator, and wait until it is done."""
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

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

from robotcore.clock import MonotonicClock
from robotcore.drive import Wheels
from tests.system.firmware.bench import HZ, shared
from tests.system.firmware.wiring import SILENCE_S, SOUND_M_S, Wiring

STANDS = "0.0000 0.0000"
"""What more is told of `duty` where neither motor is given any."""

LOOK_S = 0.002
HUNG_S = 60.0
"""No simulator is so slow that this passes on the wall before what is waited for has come or is too late."""


class Event(NamedTuple):
    """What happened (duty, line, plugged, pulled, reset, hangs, watchdog), at which of the AVR's times, in seconds."""

    time: float
    what: str
    more: str


class Board:
    """Runs a sketch. Opened by its constructor, which returns when the line can be opened at ``port``.

    ``port`` leads to the line while that is plugged in. Times are the AVR's, in seconds since it was switched on.
    """

    def __init__(self, simulator: Path, sketch: Path, wiring: Wiring) -> None:
        self._folder = TemporaryDirectory(prefix="robotcore-avr-")
        self.port = Path(self._folder.name) / "ttyUSB0"
        self._wiring = wiring
        self._bench = shared(memory := Path(self._folder.name) / "bench")
        wiring.build(self._bench)
        self.put_ahead(math.inf)
        self.charge(7.4)
        self._events: list[Event] = []
        self._process = subprocess.Popen(
            [simulator, sketch, self.port, memory], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._hearing = threading.Thread(target=self._hear, name="simulated board", daemon=True)
        self._hearing.start()
        self.wait(lambda: bool(self.events("plugged")), "the line to be plugged in")

    def now(self) -> float:
        return self._bench.cycles / HZ

    @property
    def angles(self) -> Wheels:
        """How far the wheels have turned, in radians."""
        return Wheels(self._bench.left.angle_rad, self._bench.right.angle_rad)

    @property
    def velocities(self) -> Wheels:
        """How fast they turn, in rad/s."""
        return Wheels(self._bench.left.velocity_rad_s, self._bench.right.velocity_rad_s)

    @property
    def duties(self) -> Wheels:
        """What the pins give the motors, from -1 to 1."""
        return Wheels(self._bench.left.duty, self._bench.right.duty)

    def events(self, what: str = "", since: float = 0.0) -> list[Event]:
        """Return what has happened since then, in order; of one kind, or all."""
        return [event for event in list(self._events) if event.time >= since and what in ("", event.what)]

    def put_ahead(self, distance: float) -> None:
        """Put something so many metres in front of the sonar; `inf` is nothing that it hears."""
        self._bench.echo_s = SILENCE_S if math.isinf(distance) else 2 * distance / SOUND_M_S

    def charge(self, volts: float) -> None:
        """Let the battery have so many volts."""
        self._bench.battery_mv = volts * 1000 * self._wiring.battery_ratio

    def make_noise(self, share: float) -> None:
        """Let that share of all bytes be spoilt on the line, both ways: a bit turned over, one lost, one too many."""
        self._bench.noise = share

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
        wall, end = MonotonicClock(), self.now() + within_s
        while not is_so():
            assert self._process.poll() is None, f"the simulator has ended with {self._process.returncode}"
            assert self.now() < end, f"waited {within_s:g} s of the AVR's time for {what}"
            assert wall.now() < HUNG_S, f"waited {HUNG_S:g} s for {what}, at {self.now():.3f} s of the AVR's time"
            wall.sleep_until(wall.now() + LOOK_S)

    def close(self) -> None:
        """Switch it off. May be called again."""
        if self._process.stdin and not self._process.stdin.closed:
            self._process.stdin.close()
            self._process.wait(HUNG_S)
            self._hearing.join()
            self._folder.cleanup()

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _do(self, word: str, told: str) -> None:
        """Tell the simulator a word, and wait until it has told that it was done."""
        assert self._process.stdin
        before = len(self.events(told))
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()
        self.wait(lambda: len(self.events(told)) > before, word)

    def _hear(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                cycles, what, more = (line.rstrip("\n") + " ").split(" ", 2)
                self._events.append(Event(int(cycles) / HZ, what, more.rstrip()))

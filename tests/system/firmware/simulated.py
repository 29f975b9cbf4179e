"""A simulated robot as whoever shares its memory sees it: its time, its wheels, and what it is told."""

from __future__ import annotations

import math
from pathlib import Path

from robotcore.geometry import Wheels
from tests.system.firmware.bench import HZ, Bench
from tests.system.firmware.wiring import SILENCE_S, SOUND_M_S

FOREVER = 2**64 - 1


class SimulatedRobot:
    """A robot that is simulated by this process's child, or by another's: its files are in ``folder``.

    ``port`` leads to the board's line while that is plugged in. Times are the AVR's, in seconds since it is on.
    """

    def __init__(self, folder: Path, bench: Bench) -> None:
        self.folder, self.port = folder, folder / "ttyUSB0"
        self._bench = bench

    def now(self) -> float:
        """Return the AVR's time."""
        return self._bench.cycles / HZ

    def ask_until(self, time: float) -> None:
        """Let the AVR run until then, and wait for whoever is to read its line; freely by `inf`, as it begins."""
        self._bench.asked = FOREVER if math.isinf(time) else round(time * HZ)

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

    def put_ahead(self, distance: float) -> None:
        """Put something so many metres in front of the sonar; `inf` is nothing that it hears."""
        self._bench.echo_s = SILENCE_S if math.isinf(distance) else 2 * distance / SOUND_M_S

    def charge(self, volts: float) -> None:
        """Let the battery have so many volts."""
        self._bench.battery_mv = volts * 1000 * self._bench.battery_ratio

    def make_noise(self, share: float) -> None:
        """Let that share of all bytes be spoilt on the line, both ways: a bit turned over, one lost, one too many."""
        self._bench.noise = share

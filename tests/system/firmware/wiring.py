"""How the robot is built around the board: which pin goes where, and what its motors do."""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.system.firmware.bench import JUMPER, Bench, Wheel

SOUND_M_S = 343.0
"""In air of 20 °C."""

SILENCE_S = 38e-3
"""The pulse of an HC-SR04 that heard nothing. Source: its data sheet."""


@dataclass(frozen=True)
class Side:
    """The pins of a wheel: its inputs of the L298N, and its encoder's channels, of which ``a`` leads forward."""

    forward: int
    backward: int
    a: int
    b: int
    enable: int = JUMPER


@dataclass(frozen=True)
class Motor:
    """What a motor makes of a duty: nothing up to the dead band, then a velocity in a line, with a first-order lag."""

    dead_band: float = 0.10
    full_rad_s: float = 14.0
    lag_s: float = 0.05
    edges_per_turn: float = 960.0


@dataclass(frozen=True)
class Wiring:
    """A robot's pins, by Arduino's numbers, its motors, and the divider before the battery's analog channel.

    A board that ``resets_when_opened`` listens to nobody for ``bootloader_s`` whenever its port is opened, as every Uno
    and Nano does.
    """

    left: Side
    right: Side
    trigger: int
    echo: int
    battery: int
    battery_ratio: float
    motor: Motor = field(default_factory=Motor)
    resets_when_opened: bool = True
    bootloader_s: float = 0.1

    def build(self, bench: Bench) -> None:
        """Write it all down for the simulator."""
        for wheel, side in ((bench.left, self.left), (bench.right, self.right)):
            self._build_wheel(wheel, side)
        bench.trigger, bench.echo, bench.battery = self.trigger, self.echo, self.battery
        bench.battery_ratio = self.battery_ratio
        bench.resets_when_opened, bench.bootloader_s = self.resets_when_opened, self.bootloader_s

    def _build_wheel(self, wheel: Wheel, side: Side) -> None:
        for name, value in (vars(side) | vars(self.motor)).items():
            setattr(wheel, name, value)

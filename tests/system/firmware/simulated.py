"""The simulated robot, by memory that this process shares with the simulator. avr/bench.h defines the layout."""

from __future__ import annotations

import ctypes
import math
import mmap
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from robotcore.geometry import Wheels
from robotcore.hal.wall_clock import ServerClock

HZ = 16_000_000
MEMORY = "bench"
"""The name of the shared file in a robot's folder."""

JUMPER = -1
"""The value for the enable pin of an L298N's channel that a jumper always enables."""

_INPUTS = ("forward", "backward", "enable", "a", "b")
_MODEL = ("dead_band", "full_rad_s", "lag_s", "edges_per_turn")
_STATE = ("duty", "velocity_rad_s", "angle_rad")


class Wheel(ctypes.Structure):
    """The shared state of a channel of an L298N with its motor, wheel and encoder. Pins have Arduino's numbers."""

    forward: int
    backward: int
    enable: int
    a: int
    b: int
    dead_band: float
    full_rad_s: float
    lag_s: float
    edges_per_turn: float
    duty: float
    velocity_rad_s: float
    angle_rad: float

    _fields_: ClassVar = [
        *((name, ctypes.c_int64) for name in _INPUTS),
        *((name, ctypes.c_double) for name in _MODEL + _STATE),
    ]


class Bench(ctypes.Structure):
    """The shared state of the robot around the AVR: its wiring, its inputs and its motion."""

    left: Wheel
    right: Wheel
    trigger: int
    echo: int
    battery: int
    resets_when_opened: int
    battery_ratio: float
    bootloader_s: float
    echo_s: float
    battery_mv: float
    noise: float
    cycles: int
    asked: int
    is_listening: int

    _fields_: ClassVar = [
        ("left", Wheel),
        ("right", Wheel),
        *((name, ctypes.c_int64) for name in ("trigger", "echo", "battery", "resets_when_opened")),
        *((name, ctypes.c_double) for name in ("battery_ratio", "bootloader_s", "echo_s", "battery_mv", "noise")),
        ("cycles", ctypes.c_uint64),
        ("asked", ctypes.c_uint64),
        ("is_listening", ctypes.c_int64),
    ]


def create_bench(folder: Path) -> Bench:
    """Create the shared memory in a folder, filled with zeros, and return it."""
    (folder / MEMORY).write_bytes(bytes(ctypes.sizeof(Bench)))
    return map_bench(folder)


def map_bench(folder: Path) -> Bench:
    """Map the shared memory in a folder, and return it. The simulator keeps it up to date."""
    with (folder / MEMORY).open("r+b") as file:
        return Bench.from_buffer(mmap.mmap(file.fileno(), 0))


SOUND_M_S = 343.0
"""The speed of sound in air of 20 °C, in m/s."""

SILENCE_S = 38e-3
"""The length of the pulse of an HC-SR04 without an echo, in seconds. Source: its data sheet."""


@dataclass(frozen=True)
class WheelPins:
    """The pins of a wheel: the inputs of the L298N, and the channels of the encoder.

    Channel ``a`` leads if the wheel turns forward.
    """

    forward: int
    backward: int
    a: int
    b: int
    enable: int = JUMPER


@dataclass(frozen=True)
class Motor:
    """A motor with a dead band of duties, a linear velocity above the dead band, and a first-order lag."""

    dead_band: float = 0.10
    full_rad_s: float = 14.0
    lag_s: float = 0.05
    edges_per_turn: float = 960.0


@dataclass(frozen=True)
class Wiring:
    """A robot's pins by Arduino's numbers, its motors, and the voltage divider of the battery.

    resets_when_opened: whether the board is reset when its port is opened, as every Uno and Nano is.
    bootloader_s: the time after such a reset in which the board ignores all data.
    """

    left: WheelPins
    right: WheelPins
    trigger: int
    echo: int
    battery: int
    battery_ratio: float
    motor: Motor = field(default_factory=Motor)
    resets_when_opened: bool = True
    bootloader_s: float = 0.1

    def build(self, bench: Bench) -> None:
        """Write these values into the shared memory."""
        for wheel, pins in ((bench.left, self.left), (bench.right, self.right)):
            self._build_wheel(wheel, pins)
        bench.trigger, bench.echo, bench.battery = self.trigger, self.echo, self.battery
        bench.battery_ratio = self.battery_ratio
        bench.resets_when_opened, bench.bootloader_s = self.resets_when_opened, self.bootloader_s

    def _build_wheel(self, wheel: Wheel, pins: WheelPins) -> None:
        for name, value in (vars(pins) | vars(self.motor)).items():
            setattr(wheel, name, value)


FOREVER = 2**64 - 1


class SimulatedRobot:
    """A robot that another process simulates.

    folder: the folder with its files. ``ttyUSB0`` is the board's port while the line is plugged in.
    bench: the memory that the simulator shares.
    All times are in seconds of the AVR's time, since it was switched on.
    """

    def __init__(self, folder: Path, bench: Bench) -> None:
        self.folder, self.port = folder, folder / "ttyUSB0"
        self._bench = bench

    def now(self) -> float:
        """Return the AVR's time."""
        return self._bench.cycles / HZ

    def run_until(self, time: float) -> None:
        """Let the AVR run until ``time``, and then wait. With `inf`, which is the default, the AVR never waits."""
        self._bench.asked = FOREVER if math.isinf(time) else round(time * HZ)

    @property
    def angles(self) -> Wheels:
        """The angles of the wheels in radians."""
        return Wheels(self._bench.left.angle_rad, self._bench.right.angle_rad)

    @property
    def velocities(self) -> Wheels:
        """The velocities of the wheels in rad/s."""
        return Wheels(self._bench.left.velocity_rad_s, self._bench.right.velocity_rad_s)

    @property
    def duties(self) -> Wheels:
        """The duties of the motors, from -1 to 1."""
        return Wheels(self._bench.left.duty, self._bench.right.duty)

    def place_target(self, distance: float) -> None:
        """Place a target at ``distance`` metres in front of the sonar; `inf` removes the target."""
        self._bench.echo_s = SILENCE_S if math.isinf(distance) else 2 * distance / SOUND_M_S

    def set_battery_voltage(self, volts: float) -> None:
        """Set the voltage of the battery in volts."""
        self._bench.battery_mv = volts * 1000 * self._bench.battery_ratio

    def set_noise(self, share: float) -> None:
        """Damage a share of the bytes on the line, from 0 to 1, in both directions: flip a bit, drop or add a byte."""
        self._bench.noise = share


class OnDemandClock(ServerClock):
    """A clock that lets the AVR run only while a thread sleeps. So almost no AVR time passes while a program computes.

    A thread that waits without a sleep needs the sleep of another thread. Without one, the AVR runs slowly.
    """

    def __init__(self, simulated: SimulatedRobot) -> None:
        super().__init__(simulated.now)
        self._simulated = simulated
        self._asked = simulated.now()
        simulated.run_until(self._asked)

    def sleep_until(self, deadline: float) -> bool:
        self._asked = max(self._asked, self._zero + deadline)
        self._simulated.run_until(self._asked)
        return super().sleep_until(deadline)

"""What the simulated robot is and does: memory that this process shares with the simulator, as avr/bench.h has it."""

from __future__ import annotations

import ctypes
import mmap
from pathlib import Path
from typing import ClassVar

HZ = 16_000_000
MEMORY = "bench"
"""The file in a robot's folder that holds it."""

JUMPER = -1
"""The enable pin of an L298N's channel whose jumper is on."""

_INPUTS = ("forward", "backward", "enable", "a", "b")
_MODEL = ("dead_band", "full_rad_s", "lag_s", "edges_per_turn")
_DOES = ("duty", "velocity_rad_s", "angle_rad")


class Wheel(ctypes.Structure):
    """A channel of an L298N, its motor, its wheel and the encoder on that; pins are Arduino's numbers."""

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
        *((name, ctypes.c_double) for name in _MODEL + _DOES),
    ]


class Bench(ctypes.Structure):
    """The robot around the AVR: what it is wired to, what it is told, what it does."""

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


def made(folder: Path) -> Bench:
    """Make a bench of nothing but zeros in a folder, and return it; see `joined`."""
    (folder / MEMORY).write_bytes(bytes(ctypes.sizeof(Bench)))
    return joined(folder)


def joined(folder: Path) -> Bench:
    """Return what is in that folder's bench, now and whenever it is looked at."""
    with (folder / MEMORY).open("r+b") as file:
        return Bench.from_buffer(mmap.mmap(file.fileno(), 0))

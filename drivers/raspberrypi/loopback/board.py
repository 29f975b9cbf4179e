"""The robot of the loopback test: one motor on the outputs of the wires."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from drivers.raspberrypi.loopback.wires import LoopbackWire
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceContext, bind_devices
from robotcore.kinds.motor import Motor

MOTOR = "motor"
MAX_RAD_S = 10.0
HZ = 100
"""The frequency of the motor's PWM in Hz, the default of the driver."""

_FILE = """\
name = "loopback"

[body]
length_m = 0.2
width_m = 0.2
height_m = 0.1
clearance_m = 0.02
mass_kg = 1.0

[[devices]]
kind = "motor"
name = "{motor}"
max_velocity_rad_s = {max_rad_s}

[raspberrypi.{motor}]
driver = "h-bridge"
forward = {forward}
backward = {backward}
frequency_hz = {hz}
model = {{ forward_rad_s = {max_rad_s}, backward_rad_s = {max_rad_s} }}
"""


def write_loopback_robot(wires: Sequence[LoopbackWire], folder: Path) -> Path:
    """Write the robot's file into a folder, and return its path.

    The motor turns forward by the output of wire 1, and backward by that of wire 2.
    """
    first, second = wires
    file = folder / "loopback.toml"
    text = _FILE.format(
        motor=MOTOR,
        max_rad_s=MAX_RAD_S,
        hz=HZ,
        forward=first.output,
        backward=second.output,
    )
    file.write_text(text, encoding="utf-8")
    return file


def load_loopback_robot(wires: Sequence[LoopbackWire]) -> RobotDescription:
    """Return the description of that robot."""
    with TemporaryDirectory() as folder:
        return load_robot(str(write_loopback_robot(wires, Path(folder))))


def build_context(wires: Sequence[LoopbackWire], pins: Any) -> DeviceContext:
    """Return the context in which drivers open devices of that robot, and further devices on its pins."""
    return DeviceContext(load_loopback_robot(wires), MonotonicClock(), pins)


def open_loopback_motor(wires: Sequence[LoopbackWire], pins: Any) -> Motor:
    """Open the motor with its driver. Raises DeviceError."""
    context = build_context(wires, pins)
    (binding,) = bind_devices(context.robot, "raspberrypi", [MOTOR])
    motor = binding.open(context)
    assert isinstance(motor, Motor)
    return motor

"""The robots of the guest: open one device, or run an app with a robot in another process."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from robotcore.description import load_robot
from robotcore.hal.device import Device
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceContext, bind_devices
from tests.system.speed import scaled

GUEST = Path(__file__).parent
ROBOTS = GUEST / "robots"
ENDLESS_DRIVE = str(GUEST / "apps" / "endless_drive.py")
MOTOR_LINES = {"left": (17, 27), "right": (23, 24)}
TOUR = str(GUEST / "apps" / "tour.py")
STANDBY = 22
EDGES_A_SECOND = 40.0
"""The rate of an encoder's edges at full speed, 12 rad/s: 20 edges a turn."""


def open_device(name: str, pins: Any, robot: str = "bench") -> Device:
    """Open one device of a robot in the folder ``robots``."""
    described = load_robot(str(ROBOTS / f"{robot}.toml"))
    (binding,) = bind_devices(described, "raspberrypi", [name])
    return binding.open(DeviceContext(described, MonotonicClock(), pins))


def run_command(app: str, robot: str, *options: str) -> list[str]:
    """Return the command that runs an app on the pins, at 2 Hz because the virtual machine is slow."""
    command = [sys.executable, "-m", "tests.system.guest.scaled_limits", "run", app, "--backend", "raspberrypi"]
    return [*command, "--rate", "2", "--json", "--robot", str(ROBOTS / f"{robot}.toml"), *options]


@contextmanager
def start_process(command: list[str]) -> Iterator[subprocess.Popen[str]]:
    """Run a command during the block, and kill it after that."""
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield process
        finally:
            process.send_signal(signal.SIGKILL)


ValueT = TypeVar("ValueT")

PATIENCE_S = 6.0
"""The time limit of a wait on the reference machine. An emulated processor is about ten times slower."""


def wait_until(read: Callable[[], ValueT], expected: object) -> ValueT:
    """Read until the value is as expected or the time limit is over; return the last value."""
    end = time.monotonic() + scaled(PATIENCE_S)
    while (value := read()) != expected and time.monotonic() < end:
        time.sleep(0.01)
    return value

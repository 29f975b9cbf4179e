"""The robots of the guest, opened device by device, and the app's own process with one of them."""

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
from robotcore.hal.devices import Device
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import Host, bind_devices
from tests.system.speed import scaled

GUEST = Path(__file__).parent
ROBOTS = GUEST / "robots"
ONWARDS = str(GUEST / "apps" / "onwards.py")
MOTOR_LINES = {"left": (17, 27), "right": (23, 24)}
TOUR = str(GUEST / "apps" / "tour.py")
STANDBY = 22
EDGES_A_SECOND = 40.0
"""What an encoder of the bench has at full speed, 12 rad/s: 20 edges a turn."""


def open_device(name: str, pins: Any, robot: str = "bench") -> Device:
    """Open one device of a robot of the guest's."""
    described = load_robot(str(ROBOTS / f"{robot}.toml"))
    (binding,) = bind_devices(described, "raspberrypi", [name])
    return binding.open(Host(described, MonotonicClock(), pins))


def run_command(app: str, robot: str, *options: str) -> list[str]:
    """Return the command that runs an app on the pins, slowly, for this machine is slow."""
    command = [sys.executable, "-m", "tests.system.guest.patient", "run", app, "--backend", "raspberrypi"]
    return [*command, "--rate", "2", "--json", "--robot", str(ROBOTS / f"{robot}.toml"), *options]


@contextmanager
def started(command: list[str]) -> Iterator[subprocess.Popen[str]]:
    """Run a command beside the check; it does not outlive it."""
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield process
        finally:
            process.send_signal(signal.SIGKILL)


ValueT = TypeVar("ValueT")

PATIENCE_S = 6.0
"""On the reference machine; an emulated processor is some ten times slower."""


def settled(got: Callable[[], ValueT], expected: object) -> ValueT:
    """Return what was got last: what is expected as soon as it is, anything else when patience is at its end."""
    end = time.monotonic() + scaled(PATIENCE_S)
    while (value := got()) != expected and time.monotonic() < end:
        time.sleep(0.01)
    return value

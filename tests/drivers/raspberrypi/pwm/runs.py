"""Starts the command line as on a Raspberry Pi 3, with a robot whose motors are on a simulated PCA9685."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress

from tests.drivers.raspberrypi.i2c_dev import ROOT, Bus
from tests.drivers.raspberrypi.lines import Lines

GUEST = ROOT / "tests" / "system" / "guest"
ROBOT = GUEST / "robots" / "pwm_chip.toml"
Program = subprocess.Popen[str]


def start_program(bus: Bus, lines: Lines, command: str, *options: str) -> Program:
    """Start a command of robotcore on the backend `raspberrypi`."""
    path = os.pathsep.join([bus.environment["PYTHONPATH"], lines.environment["PYTHONPATH"]])
    where = ["--backend", "raspberrypi", "--robot", str(ROBOT)]
    return subprocess.Popen(
        [sys.executable, "-m", "tests.drivers.raspberrypi.run_as_pi", command, *options, *where],
        cwd=ROOT,
        env={**lines.environment, **bus.environment, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def start_app(bus: Bus, lines: Lines, app: str) -> Program:
    """Start a run of an app of the guest."""
    return start_program(bus, lines, "run", str(GUEST / "apps" / f"{app}.py"), "--json")


def wait_until(bus: Bus, program: Program, *, turning: bool) -> None:
    """Wait until a motor turns, or until every channel is off. The test's time limit ends the wait otherwise."""
    while any(bus.duties()) != turning:
        with suppress(subprocess.TimeoutExpired):
            program.wait(0.005)
            raise AssertionError(program.communicate())

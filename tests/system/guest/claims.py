from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from drivers.raspberrypi.chip import list_chips
from tests.system.guest.bench import ENDLESS_DRIVE, open_device, run_command, start_process
from tests.system.guest.chip import Chip

ORDINARY_USER = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups")
SEES_THE_PROGRAM = ("--inh-caps=+dac_read_search", "--ambient-caps=+dac_read_search")
"""The user may read all files of this checkout's Python, and write no more than before."""

HOLDING = """
import lgpio, sys
chip = lgpio.gpiochip_open(0)
lgpio.gpio_claim_output(chip, 17, 0)
print("holding", flush=True)
sys.stdin.read()
"""


def test_a_line_that_another_program_holds_is_reported_with_its_holder(chip: Chip) -> None:
    with start_process([sys.executable, "-c", HOLDING]) as holder:
        assert holder.stdout
        assert holder.stdout.readline() == "holding\n"
        run = subprocess.run(run_command(ENDLESS_DRIVE, "plain"), capture_output=True, text=True, check=False)
    assert re.search(rf"left_motor: GPIO 17 .*\b{holder.pid}\b", run.stderr), run.stderr
    assert run.returncode == 3


def test_the_lines_of_a_closed_robot_are_free(chip: Chip, pins: Any) -> None:
    open_device("left_motor", pins).close()
    pins.close()
    with start_process([sys.executable, "-c", HOLDING]) as holder:
        assert holder.stdout
        assert holder.stdout.readline() == "holding\n"


def test_the_kernel_names_the_driver_of_a_chip(chip: Chip) -> None:
    """The driver's name identifies the header's chip."""
    assert ("gpio-sim", 0) in [(driver, number) for number, driver in list_chips(Path("/"))]


def test_a_missing_permission_is_reported(chip: Chip) -> None:
    assert Path("/dev/gpiochip0").stat().st_mode & 0o077 == 0
    command = [*ORDINARY_USER, *SEES_THE_PROGRAM, *run_command(ENDLESS_DRIVE, "plain")]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 3, run.stderr
    assert "/dev/gpiochip0" in run.stderr + run.stdout

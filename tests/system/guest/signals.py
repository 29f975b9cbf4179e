from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.system.guest.bench import MOTOR_LINES, ONWARDS, ROBOTS, STANDBY, run_command, settled, started
from tests.system.guest.chip import Chip

FORWARD = MOTOR_LINES["left"][0]

AT_FULL_SPEED = ("--set", "speed_m_s=1")
"""A line is high all the time then, not only in its part of a cycle."""

BARE = """
import sys
from gpiozero import Motor
from gpiozero.pins.lgpio import LGPIOFactory
motor = Motor(17, 27, pin_factory=LGPIOFactory())
motor.forward()
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _lines_keep_their_level(chip: Chip) -> None:
    chip.set_persistent(is_persistent=True)


def test_sigterm_while_driving_leaves_every_line_low(chip: Chip) -> None:
    with started(run_command(ONWARDS, "plain")) as app:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.send_signal(signal.SIGTERM)
        printed, _ = app.communicate()
    assert (app.returncode, json.loads(printed)["exit_status"]) == (-signal.SIGTERM, 128 + signal.SIGTERM)
    assert settled(chip.high, []) == []


def test_sigkill_while_driving_leaves_every_line_low_by_the_guardian(chip: Chip) -> None:
    with started(run_command(ONWARDS, "plain")) as app:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.kill()
    assert settled(chip.high, []) == []


def test_sigkill_while_driving_leaves_the_board_asleep_by_the_guardian(chip: Chip) -> None:
    with started(run_command(ONWARDS, "standby")) as app:
        assert settled(lambda: chip.level(STANDBY), 1) == 1
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.kill()
    assert settled(lambda: chip.level(STANDBY), 0) == 0


@pytest.mark.parametrize("robot, high", [("plain", FORWARD), ("standby", STANDBY)])
def test_lines_that_nobody_is_left_to_pull_low_are_pulled_low_by_robotcore_stop(
    chip: Chip, robot: str, high: int
) -> None:
    with started(run_command(ONWARDS, robot, *AT_FULL_SPEED)) as app:
        assert settled(lambda: chip.level(high), 1) == 1
        os.kill(guardian_of(app.pid), signal.SIGKILL)
        app.kill()
    assert chip.level(high) == 1
    stopped = stopping(robot)
    assert (stopped.returncode, stopped.stderr) == (0, "")
    assert chip.level(high) == 0


def test_a_program_that_lives_keeps_its_lines_and_is_named_by_robotcore_stop(chip: Chip) -> None:
    with started([sys.executable, "-c", BARE]) as program:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        stopped = stopping("plain")
        assert (stopped.returncode, stopped.stdout) == (3, "plain: stopped right_motor\n")
        assert re.search(rf"left_motor: GPIO {FORWARD} is held by .*process {program.pid} ", stopped.stderr)
        assert program.poll() is None
        assert chip.level(FORWARD) == 1


@pytest.mark.parametrize("is_persistent", [True, False])
def test_without_a_guardian_sigkill_leaves_a_line_high_where_it_keeps_its_level(
    chip: Chip, is_persistent: bool
) -> None:
    chip.set_persistent(is_persistent=is_persistent)
    with started([sys.executable, "-c", BARE]) as program:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        program.kill()
        program.wait()
    left = [FORWARD] if is_persistent else []
    assert settled(chip.high, left) == left


def guardian_of(app: int) -> int:
    """Return the number of the one process that an app's has started."""
    (child,) = Path(f"/proc/{app}/task/{app}/children").read_text().split()
    return int(child)


def stopping(robot: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "robotcore", "stop", "--backend", "raspberrypi"]
    command += ["--robot", str(ROBOTS / f"{robot}.toml")]
    return subprocess.run(command, capture_output=True, text=True, check=False)

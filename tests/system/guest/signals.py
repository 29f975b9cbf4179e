from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.system.guest.bench import ENDLESS_DRIVE, MOTOR_LINES, ROBOTS, STANDBY, run_command, start_process, wait_until
from tests.system.guest.chip import Chip

FORWARD = MOTOR_LINES["left"][0]

AT_FULL_SPEED = ("--set", "speed_m_s=1")
"""At full duty the line is high all the time."""

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
    with start_process(run_command(ENDLESS_DRIVE, "plain")) as app:
        assert wait_until(lambda: chip.level(FORWARD), 1) == 1
        app.send_signal(signal.SIGTERM)
        printed, _ = app.communicate()
    assert (app.returncode, json.loads(printed)["exit_status"]) == (-signal.SIGTERM, 128 + signal.SIGTERM)
    assert wait_until(chip.high, []) == []


def test_the_guardian_pulls_every_line_low_after_sigkill(chip: Chip) -> None:
    with start_process(run_command(ENDLESS_DRIVE, "plain")) as app:
        assert wait_until(lambda: chip.level(FORWARD), 1) == 1
        app.kill()
    assert wait_until(chip.high, []) == []


def test_the_guardian_lets_the_board_sleep_after_sigkill(chip: Chip) -> None:
    with start_process(run_command(ENDLESS_DRIVE, "standby")) as app:
        assert wait_until(lambda: chip.level(STANDBY), 1) == 1
        assert wait_until(lambda: chip.level(FORWARD), 1) == 1
        app.kill()
    assert wait_until(lambda: chip.level(STANDBY), 0) == 0


@pytest.mark.parametrize("robot, high", [("plain", FORWARD), ("standby", STANDBY)])
def test_robotcore_stop_pulls_lines_low_after_app_and_guardian_are_killed(chip: Chip, robot: str, high: int) -> None:
    with start_process(run_command(ENDLESS_DRIVE, robot, *AT_FULL_SPEED)) as app:
        assert wait_until(lambda: chip.level(high), 1) == 1
        os.kill(guardian_of(app.pid), signal.SIGKILL)
        app.kill()
    assert chip.level(high) == 1
    stopped = stop_robot(robot)
    assert (stopped.returncode, stopped.stderr) == (0, "")
    assert chip.level(high) == 0


def test_a_live_program_keeps_its_lines_and_robotcore_stop_names_it(chip: Chip) -> None:
    with start_process([sys.executable, "-c", BARE]) as program:
        assert wait_until(lambda: chip.level(FORWARD), 1) == 1
        stopped = stop_robot("plain")
        assert (stopped.returncode, stopped.stdout) == (3, "plain: stopped right_motor\n")
        assert re.search(rf"left_motor: GPIO {FORWARD} .*\b{program.pid}\b", stopped.stderr)
        assert program.poll() is None
        assert chip.level(FORWARD) == 1


@pytest.mark.parametrize("is_persistent", [True, False])
def test_without_a_guardian_a_persistent_line_stays_high_after_sigkill(chip: Chip, is_persistent: bool) -> None:
    chip.set_persistent(is_persistent=is_persistent)
    with start_process([sys.executable, "-c", BARE]) as program:
        assert wait_until(lambda: chip.level(FORWARD), 1) == 1
        program.kill()
        program.wait()
    left = [FORWARD] if is_persistent else []
    assert wait_until(chip.high, left) == left


def guardian_of(app: int) -> int:
    """Return the number of the only child of an app's process."""
    (child,) = Path(f"/proc/{app}/task/{app}/children").read_text().split()
    return int(child)


def stop_robot(robot: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "robotcore", "stop", "--backend", "raspberrypi"]
    command += ["--robot", str(ROBOTS / f"{robot}.toml")]
    return subprocess.run(command, capture_output=True, text=True, check=False)

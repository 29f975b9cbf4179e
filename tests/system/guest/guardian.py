from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.system.guest.bench import ENDLESS_DRIVE, MOTOR_LINES, STANDBY, run_command, start_process, wait_until
from tests.system.guest.chip import Chip
from tests.system.speed import scaled

PROCESS_FAILURE = str(Path(ENDLESS_DRIVE).with_name("process_failure.py"))
LINES = [gpio for lines in MOTOR_LINES.values() for gpio in lines]
LIMIT_S = 12
"""The time limit of a run, on the reference machine."""
HALTING = """
import os, signal, time
from drivers.raspberrypi.pins import open_pins
from tests.system.guest.bench import open_device
motor = open_device("left_motor", open_pins(), "plain")
while print("on", flush=True) is None:
    motor.set_velocity(6.0)
    time.sleep(0.1)
    motor.stop()
    os.kill(os.getpid(), signal.SIGSTOP)
"""


@pytest.fixture(autouse=True)
def _lines_keep_their_level(chip: Chip) -> None:
    chip.set_persistent(is_persistent=True)


def test_an_app_that_hangs_while_it_drives_is_killed_and_its_lines_are_low(chip: Chip) -> None:
    for gpio in LINES:
        chip.pull(gpio, 1)
    app = run(PROCESS_FAILURE, "plain", "--set", "action=hold")
    assert (app.returncode, app.stdout) == (-signal.SIGKILL, "")
    assert "left_motor, right_motor" in app.stderr
    assert app.stderr.count("guardian: ") >= 2
    assert chip.high() == []
    assert {chip.file(gpio, "pull").read_text().strip() for gpio in LINES} == {"pull-down"}


def test_a_hung_app_with_a_standby_line_lives_and_its_board_sleeps(chip: Chip) -> None:
    with start_process(run_command(PROCESS_FAILURE, "standby")) as app:
        wait_until_high(chip, STANDBY, app)
        assert wait_until(lambda: chip.level(STANDBY), 0) == 0
        assert app.poll() is None


def test_an_app_that_hangs_at_rest_is_not_killed(chip: Chip) -> None:
    app = run(PROCESS_FAILURE, "plain", "--set", "action=stop_and_hold")
    assert (app.returncode, app.stderr) == (0, "")
    assert json.loads(app.stdout)["outcome"] == "success"


def test_a_fork_of_a_killed_app_keeps_no_line_high(chip: Chip) -> None:
    with start_process(run_command(PROCESS_FAILURE, "plain", "--set", "action=fork_and_kill")) as app:
        assert app.wait(scaled(LIMIT_S)) == -signal.SIGKILL
        assert app.stderr
        assert "left_motor, right_motor" in app.stderr.readline()  # the fork lives on
        assert chip.high() == []


def test_a_stop_is_low_even_if_the_process_is_suspended_right_after_it(chip: Chip) -> None:
    """Software PWM is suspended anywhere in its cycle, so the check runs 20 rounds."""
    with start_process([sys.executable, "-c", HALTING]) as program:
        assert program.stdout
        for _ in range(20):
            assert program.stdout.readline() == "on\n"
            assert wait_until(lambda: state(program.pid), "T") == "T"
            assert chip.high() == []
            program.send_signal(signal.SIGCONT)


def wait_until_high(chip: Chip, gpio: int, app: subprocess.Popen[str]) -> None:
    """Wait until an app drives; the check's time limit ends a wait in vain."""
    while not chip.level(gpio):
        assert app.poll() is None, app.communicate()
        time.sleep(0.01)


def state(process: int) -> str:
    """Return the letter of a process's state."""
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]


def run(app: str, robot: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = run_command(app, robot, *options)
    return subprocess.run(command, capture_output=True, text=True, timeout=scaled(LIMIT_S), check=False)

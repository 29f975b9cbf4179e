from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.system.guest.bench import MOTOR_LINES, ONWARDS, STANDBY, run_command, settled, started
from tests.system.guest.chip import Chip
from tests.system.speed import scaled

UNTOWARD = str(Path(ONWARDS).with_name("untoward.py"))
LINES = [gpio for lines in MOTOR_LINES.values() for gpio in lines]
LIMIT_S = 12
"""Of a run of the app, on the reference machine: a hang."""
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


def test_a_hung_app_that_drives_is_ended_and_its_lines_are_low(chip: Chip) -> None:
    for gpio in LINES:
        chip.pull(gpio, 1)
    app = run(UNTOWARD, "plain", "--set", "deed=holds")
    assert (app.returncode, app.stdout) == (-signal.SIGKILL, "")
    assert "broke off; stopped left_motor, right_motor\nguardian: ended process " in app.stderr
    assert chip.high() == []
    assert {chip.file(gpio, "pull").read_text().strip() for gpio in LINES} == {"pull-down"}


def test_a_hung_app_whose_board_has_a_standby_line_lives_on_with_the_board_asleep(chip: Chip) -> None:
    with started(run_command(UNTOWARD, "standby")) as app:
        until_high(chip, STANDBY, app)
        assert settled(lambda: chip.level(STANDBY), 0) == 0
        assert app.poll() is None


def test_an_app_that_hangs_at_rest_is_not_ended(chip: Chip) -> None:
    app = run(UNTOWARD, "plain", "--set", "deed=rests")
    assert (app.returncode, app.stderr) == (0, "")
    assert json.loads(app.stdout)["outcome"] == "success"


def test_a_copy_of_a_killed_app_s_process_keeps_no_line_high(chip: Chip) -> None:
    with started(run_command(UNTOWARD, "plain", "--set", "deed=copies")) as app:
        assert app.wait(scaled(LIMIT_S)) == -signal.SIGKILL
        assert app.stderr
        assert "broke off; stopped left_motor, right_motor" in app.stderr.readline()  # the copy lives on
        assert chip.high() == []


def test_a_motor_that_was_reported_to_stand_has_its_lines_low_when_its_process_is_suspended_at_once(chip: Chip) -> None:
    """Software PWM stands still too, wherever in its cycle it is: hence some rounds."""
    with started([sys.executable, "-c", HALTING]) as program:
        assert program.stdout
        for _ in range(20):
            assert program.stdout.readline() == "on\n"
            assert settled(lambda: state(program.pid), "T") == "T"
            assert chip.high() == []
            program.send_signal(signal.SIGCONT)


def until_high(chip: Chip, gpio: int, app: subprocess.Popen[str]) -> None:
    """Wait for an app to drive; one that waits in vain is ended by the check's time limit."""
    while not chip.level(gpio):
        assert app.poll() is None, app.communicate()
        time.sleep(0.01)


def state(process: int) -> str:
    """Return the state of a process in one letter."""
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]


def run(app: str, robot: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = run_command(app, robot, *options)
    return subprocess.run(command, capture_output=True, text=True, timeout=scaled(LIMIT_S), check=False)

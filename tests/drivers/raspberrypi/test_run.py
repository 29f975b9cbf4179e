"""Runs of the command line with the guardian on simulated lines. They are killed or suspended, or hang."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.drivers.raspberrypi.lines import END_S, ROOT, Launch, Lines, Program, wait_for_end, wait_for_level
from tests.texts import CheckText

GUEST = ROOT / "tests" / "system" / "guest"
FORWARD, BACKWARD, STANDBY = (17, 23), (27, 24), 22
Start = Callable[..., Program]


@pytest.fixture
def start(launch: Launch) -> Start:
    def start(robot: str, app: str, *options: str) -> Program:
        where = ["--backend", "raspberrypi", "--robot", str(GUEST / "robots" / f"{robot}.toml"), "--json"]
        run = ["run", str(GUEST / "apps" / f"{app}.py"), *where, *options]
        return launch("tests.drivers.raspberrypi.run_as_pi", *run)

    return start


def levels(lines: Lines) -> set[int]:
    return {lines.level(gpio) for gpio in (*FORWARD, *BACKWARD)}


@pytest.mark.slow
def test_a_run_that_is_terminated_leaves_every_line_low(start: Start, lines: Lines) -> None:
    program = start("plain", "endless_drive")
    wait_for_level(lines, FORWARD[0], program, is_high=True)
    program.terminate()
    out, err = wait_for_end(program)
    assert (program.returncode, json.loads(out)["outcome"]) == (-signal.SIGTERM, "interrupted"), err
    assert levels(lines) == {0}


@pytest.mark.slow
def test_the_guardian_pulls_the_lines_of_a_killed_run_low(start: Start, lines: Lines, check_text: CheckText) -> None:
    program = start("plain", "endless_drive")
    wait_for_level(lines, FORWARD[1], program, is_high=True)
    program.kill()
    _, err = wait_for_end(program)
    check_text(err.splitlines()[-1], hide=[program.pid])  # on a busy machine a stop is late, which is a line before
    assert levels(lines) == {0}


@pytest.mark.slow
def test_the_guardian_kills_a_run_that_hangs_while_it_drives(start: Start, lines: Lines) -> None:
    program = start("plain", "process_failure")
    _, err = wait_for_end(program)
    assert program.returncode == -signal.SIGKILL
    assert f"\nguardian: killed process {program.pid}, which was silent" in err
    assert levels(lines) == {0}


@pytest.mark.slow
def test_one_guardian_holds_the_standby_line_of_two_motors_and_does_not_kill_a_hung_run(
    start: Start, lines: Lines
) -> None:
    program = start("standby", "process_failure")
    wait_for_level(lines, STANDBY, program, is_high=True)
    wait_for_level(lines, STANDBY, program, is_high=False)
    out, err = wait_for_end(program)
    assert (program.returncode, err) == (0, "")
    assert json.loads(out)["outcome"] == "success"
    assert lines.level(STANDBY) == 0


MOTORS = (17, 27, 23, 24)
DRIVING = """
import lgpio, sys
chip = lgpio.gpiochip_open(0)
for gpio in map(int, sys.argv[1:]):
    lgpio.gpio_claim_output(chip, gpio, 1)
print("drives", flush=True)
sys.stdin.read()
"""


def robot(name: str) -> str:
    return str(ROOT / "tests" / "system" / "guest" / "robots" / f"{name}.toml")


@contextmanager
def drive_lines(lines: Lines, *gpios: int) -> Iterator[None]:
    """Run a program that holds these lines high."""
    command = [sys.executable, "-c", DRIVING, *map(str, gpios)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=lines.environment, stdin=pipe, stdout=pipe) as program:
        assert program.stdout
        assert program.stdout.readline() == b"drives\n"
        yield
        assert program.poll() is None
        program.kill()


def stop_robot(launch: Launch, name: str) -> tuple[int, str, str]:
    program = launch("robotcore", "stop", "--backend", "raspberrypi", "--robot", robot(name))
    out, err = program.communicate(timeout=END_S)
    return program.returncode, out, err


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, left_high, stopped",
    [("plain", MOTORS, "left_motor, right_motor"), ("standby", [STANDBY], "left_motor and right_motor")],
)
def test_lines_that_a_dead_program_has_left_high_are_pulled_low(
    lines: Lines, launch: Launch, name: str, left_high: list[int], stopped: str
) -> None:
    with drive_lines(lines, *left_high):
        pass
    assert [lines.level(gpio) for gpio in left_high] == [1] * len(left_high)
    assert stop_robot(launch, name) == (0, f"{name}: stopped {stopped}\n", "")
    assert [lines.level(gpio) for gpio in left_high] == [0] * len(left_high)
    assert all(lines.is_pulled_down(gpio) for gpio in left_high)


@pytest.mark.slow
def test_a_live_program_keeps_its_lines_and_all_other_lines_are_pulled_low(
    lines: Lines, launch: Launch, check_text: CheckText
) -> None:
    with drive_lines(lines, *MOTORS):
        pass
    with drive_lines(lines, 17):
        status, out, err = stop_robot(launch, "plain")
    assert (status, out) == (3, "plain: stopped right_motor\n")
    check_text(re.sub(r"held by .*\. End", "held by …. End", err))
    assert [lines.level(gpio) for gpio in MOTORS] == [1, 0, 0, 0]


@pytest.mark.slow
def test_the_standby_line_of_a_live_guardian_is_not_taken(lines: Lines, launch: Launch, check_text: CheckText) -> None:
    with drive_lines(lines, STANDBY):
        status, _, err = stop_robot(launch, "standby")
    assert status == 3
    check_text(re.sub(r"held by .*\. End", "held by …. End", err))

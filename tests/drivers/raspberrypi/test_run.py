"""Runs of the command line with the guardian on simulated lines. They are killed or suspended, or hang."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest

from tests.drivers.raspberrypi.lines import END_S, ROOT, Lines, hold_lines
from tests.texts import CheckText

GUEST = ROOT / "tests" / "system" / "guest"
FORWARD, BACKWARD, STANDBY = (17, 23), (27, 24), 22
Program = subprocess.Popen[str]
Launch = Callable[..., Program]


@pytest.fixture
def launch(lines: Lines) -> Iterator[Launch]:
    """Start the command line as on a Raspberry Pi 3, with a robot; the process is killed after the test."""
    programs: list[Program] = []

    def launch(command: str, robot: str, *options: str) -> Program:
        where = ["--backend", "raspberrypi", "--robot", str(GUEST / "robots" / f"{robot}.toml")]
        program = subprocess.Popen(
            [sys.executable, "-m", "tests.drivers.raspberrypi.run_as_pi", command, *options, *where],
            cwd=ROOT,
            env=lines.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        programs.append(program)
        return program

    yield launch
    for program in programs:
        program.kill()
        program.communicate(timeout=END_S)


def run_app(launch: Launch, robot: str, app: str) -> Program:
    return launch("run", robot, str(GUEST / "apps" / f"{app}.py"), "--json")


def wait_for_level(lines: Lines, gpio: int, program: Program, *, is_high: bool) -> None:
    """Wait until a line is high or low. The test's time limit ends the wait otherwise."""
    while bool(lines.level(gpio)) != is_high:
        with suppress(subprocess.TimeoutExpired):
            program.wait(0.01)
            raise AssertionError(program.communicate())


def levels(lines: Lines) -> set[int]:
    return {lines.level(gpio) for gpio in (*FORWARD, *BACKWARD)}


@pytest.mark.slow
def test_a_run_that_is_terminated_leaves_every_line_low(launch: Launch, lines: Lines) -> None:
    program = run_app(launch, "plain", "endless_drive")
    wait_for_level(lines, FORWARD[0], program, is_high=True)
    program.terminate()
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, json.loads(out)["outcome"]) == (-signal.SIGTERM, "interrupted"), err
    assert levels(lines) == {0}


@pytest.mark.slow
def test_the_guardian_kills_a_run_that_hangs_while_it_drives(launch: Launch, lines: Lines) -> None:
    program = run_app(launch, "plain", "process_failure")
    _, err = program.communicate(timeout=END_S)
    assert program.returncode == -signal.SIGKILL
    assert f"\nguardian: killed process {program.pid}, which was silent" in err
    assert levels(lines) == {0}


@pytest.mark.slow
def test_one_guardian_holds_the_standby_line_of_two_motors_and_does_not_kill_a_hung_run(
    launch: Launch, lines: Lines
) -> None:
    program = run_app(launch, "standby", "process_failure")
    wait_for_level(lines, STANDBY, program, is_high=True)
    wait_for_level(lines, STANDBY, program, is_high=False)
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, err) == (0, "")
    assert json.loads(out)["outcome"] == "success"
    assert lines.level(STANDBY) == 0


MOTORS = (17, 27, 23, 24)


def stop_robot(launch: Launch, name: str) -> tuple[int, str, str]:
    program = launch("stop", name)
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
    with hold_lines(lines, *left_high):
        pass
    assert [lines.level(gpio) for gpio in left_high] == [1] * len(left_high)
    assert stop_robot(launch, name) == (0, f"{name}: stopped {stopped}\n", "")
    assert [lines.level(gpio) for gpio in left_high] == [0] * len(left_high)
    assert all(lines.is_pulled_down(gpio) for gpio in left_high)


@pytest.mark.slow
def test_a_live_program_keeps_its_lines_and_all_other_lines_are_pulled_low(
    lines: Lines, launch: Launch, check_text: CheckText
) -> None:
    with hold_lines(lines, *MOTORS):
        pass
    with hold_lines(lines, 17):
        status, out, err = stop_robot(launch, "plain")
    assert (status, out) == (3, "plain: stopped right_motor\n")
    check_text(re.sub(r"held by .*\. End", "held by …. End", err))
    assert [lines.level(gpio) for gpio in MOTORS] == [1, 0, 0, 0]


@pytest.mark.slow
def test_the_standby_line_of_a_live_guardian_is_not_taken(lines: Lines, launch: Launch, check_text: CheckText) -> None:
    with hold_lines(lines, STANDBY):
        status, _, err = stop_robot(launch, "standby")
    assert status == 3
    check_text(re.sub(r"held by .*\. End", "held by …. End", err))

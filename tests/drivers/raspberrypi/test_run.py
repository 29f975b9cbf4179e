"""Whole runs on the lines of these tests: command line, drivers, gpiozero, guardian, and what befalls them."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable

import pytest

from tests.drivers.raspberrypi.lines import END_S, ROOT, Launch, Lines, Program

GUEST = ROOT / "tests" / "system" / "guest"
FORWARD, BACKWARD, STANDBY = (17, 23), (27, 24), 22
Start = Callable[..., Program]


@pytest.fixture
def start(launch: Launch) -> Start:
    def start(robot: str, app: str, *options: str) -> Program:
        where = ["--backend", "raspberrypi", "--robot", str(GUEST / "robots" / f"{robot}.toml"), "--json"]
        run = ["run", str(GUEST / "apps" / f"{app}.py"), *where, *options]
        return launch("tests.drivers.raspberrypi.on_a_pi", *run)

    return start


def over(program: Program) -> tuple[str, str]:
    """Return what it has said, once neither it nor its guardian is there any more."""
    return program.communicate(timeout=END_S)


def until(lines: Lines, gpio: int, program: Program) -> None:
    """Wait for a line to be high; a test that waits in vain is ended by its time limit."""
    while not lines.level(gpio):
        assert program.poll() is None, program.communicate()
        with pytest.raises(subprocess.TimeoutExpired):
            program.wait(0.01)


def levels(lines: Lines) -> set[int]:
    return {lines.level(gpio) for gpio in (*FORWARD, *BACKWARD)}


def test_a_run_that_is_terminated_leaves_every_line_low(start: Start, lines: Lines) -> None:
    program = start("plain", "onwards")
    until(lines, FORWARD[0], program)
    program.terminate()
    out, err = over(program)
    assert (program.returncode, json.loads(out)["outcome"]) == (-signal.SIGTERM, "interrupted"), err
    assert levels(lines) == {0}


def test_a_run_that_is_killed_has_its_lines_low_by_the_guardian(start: Start, lines: Lines) -> None:
    program = start("plain", "onwards")
    until(lines, FORWARD[1], program)
    program.kill()
    _, err = over(program)
    assert err == f"guardian: the run of process {program.pid} broke off; stopped left_motor, right_motor\n"
    assert levels(lines) == {0}


def test_a_run_that_hangs_while_it_drives_is_ended_by_the_guardian(start: Start, lines: Lines) -> None:
    program = start("plain", "untoward")
    _, err = over(program)
    assert program.returncode == -signal.SIGKILL
    assert f"\nguardian: ended process {program.pid}: it was silent" in err
    assert levels(lines) == {0}


def test_a_run_that_hangs_at_rest_is_not_ended(start: Start) -> None:
    program = start("plain", "untoward", "--set", "deed=rests")
    out, err = over(program)
    assert (program.returncode, err) == (0, "")
    assert json.loads(out)["outcome"] == "success"


def test_one_guardian_holds_the_standby_line_of_two_motors_and_lets_a_hung_run_live(start: Start, lines: Lines) -> None:
    program = start("standby", "untoward")
    until(lines, STANDBY, program)
    while lines.level(STANDBY):
        with pytest.raises(subprocess.TimeoutExpired):
            program.wait(0.01)
    out, err = over(program)
    assert (program.returncode, err) == (0, "")
    assert json.loads(out)["outcome"] == "success"
    assert lines.level(STANDBY) == 0

"""A guardian stops the motors of programs that are killed, suspended or hang, on simulated lines."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from drivers.raspberrypi.cutoff import Owner
from tests.drivers.raspberrypi.lines import END_S, Launch, Lines, Program, wait_for_end, wait_for_level
from tests.drivers.raspberrypi.turning import BACKWARD, DUTY, FORWARD, STANDBY
from tests.texts import CheckText

KILLED = -signal.SIGKILL
Start = Callable[..., Program]


@pytest.fixture
def start(launch: Launch) -> Start:
    def start(cutoff: str, action: str) -> Program:
        program = launch("tests.drivers.raspberrypi.turning", cutoff, action, stdin=subprocess.PIPE)
        assert program.stdout
        assert program.stdout.readline() == "turning\n", program.communicate()
        return program

    return start


def test_without_a_guardian_a_killed_program_leaves_its_motor_on(lines: Lines) -> None:
    """Without a guardian the lines stay high. So the guardian is the cause if the lines fall in other tests."""
    left = "import lgpio; lgpio.tx_pwm(lgpio.gpiochip_open(0), 17, 100, 60); import os; os.kill(os.getpid(), 9)"
    subprocess.run([sys.executable, "-c", left], env=lines.environment, timeout=END_S, check=False)
    assert lines.level(17) == 60


def test_the_lines_of_a_killed_program_go_low(start: Start, lines: Lines, check_text: CheckText) -> None:
    program = start("MotorLines", "drive")
    assert lines.level(FORWARD) == DUTY
    program.kill()
    _, err = wait_for_end(program)
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 0
    assert lines.is_pulled_down(FORWARD)
    assert lines.is_pulled_down(BACKWARD)
    check_text(err, hide=[program.pid])


@pytest.mark.slow
@pytest.mark.parametrize("action", ["block", "suspend", "raise_error"])
def test_a_silent_program_whose_motor_turns_is_killed(
    start: Start, lines: Lines, action: str, check_text: CheckText
) -> None:
    program = start("MotorLines", action)
    out, err = wait_for_end(program)
    assert (program.returncode, out) == (KILLED, "")
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 0
    check_text(err.splitlines()[-1], hide=[program.pid])  # on a busy machine a stop is late, which is a line before


@pytest.mark.slow
@pytest.mark.parametrize("action", ["block_at_rest", "raise_at_rest"])
def test_a_silent_program_whose_motors_stand_is_not_killed(start: Start, lines: Lines, action: str) -> None:
    program = start("MotorLines", action)
    out, err = wait_for_end(program)
    assert (program.returncode, out) == (0, "lives\n")
    assert f"{program.pid}: " not in err
    assert lines.level(FORWARD) == 0


@pytest.mark.slow
def test_a_program_that_ends_normally_is_not_killed(start: Start) -> None:
    program = start("MotorLines", "drive")
    assert program.communicate("end\n", timeout=END_S) == ("lives\n", "")
    assert program.returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("cutoff", ["MotorLines", "StandbyLine"])
def test_a_fork_of_a_killed_program_keeps_no_motor_on(
    start: Start, lines: Lines, cutoff: str, check_text: CheckText
) -> None:
    program = start(cutoff, "fork_and_die")
    program.wait(END_S)
    assert program.stderr
    check_text(program.stderr.readline(), hide=[program.pid])  # the fork lives on
    assert lines.level(FORWARD if cutoff == "MotorLines" else STANDBY) == 0


@pytest.mark.slow
@pytest.mark.parametrize("action", ["block", "block_at_rest", "raise_at_rest"])
def test_a_standby_line_falls_and_its_program_lives_on(start: Start, lines: Lines, action: str) -> None:
    program = start("StandbyLine", action)
    wait_for_level(lines, STANDBY, program, is_high=False)
    out, _ = wait_for_end(program)
    assert (program.returncode, out) == (0, "lives\n")


@pytest.mark.slow
def test_a_standby_line_falls_while_its_program_is_suspended_and_rises_when_it_drives_again(
    start: Start, lines: Lines
) -> None:
    program = start("StandbyLine", "drive")
    wait_for_level(lines, STANDBY, program, is_high=True)
    program.send_signal(signal.SIGSTOP)
    wait_for_level(lines, STANDBY, program, is_high=False)
    program.send_signal(signal.SIGCONT)
    wait_for_level(lines, STANDBY, program, is_high=True)
    program.communicate("end\n", timeout=END_S)
    assert lines.level(STANDBY) == 0


def test_a_standby_line_falls_when_its_program_is_killed(start: Start, lines: Lines) -> None:
    program = start("StandbyLine", "drive")
    wait_for_level(lines, STANDBY, program, is_high=True)
    program.kill()
    wait_for_end(program)
    assert lines.level(STANDBY) == 0
    assert lines.is_pulled_down(STANDBY)


HALF_GONE = """
import ctypes, threading, time
threading.Thread(target=time.sleep, args=(600,)).start()
input()
ctypes.CDLL(None).pthread_exit(None)
"""


@pytest.fixture
def process() -> Iterator[subprocess.Popen[str]]:
    """Return a process that waits for input. After the input, its main thread ends, but another thread continues."""
    with subprocess.Popen([sys.executable, "-c", HALF_GONE], stdin=subprocess.PIPE, text=True) as running:
        yield running
        running.kill()


def test_a_waiting_process_is_not_ending(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    assert not owner.is_ending()
    assert not owner.has_ended_within(0.0)
    owner.close()


def test_an_ending_process_with_running_threads_can_still_be_killed(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    assert process.stdin
    process.stdin.write("\n")
    process.stdin.flush()
    while not owner.is_ending():
        pass
    assert not owner.has_ended_within(0.0)
    owner.kill()
    assert owner.has_ended_within(60.0)
    assert process.wait() == -signal.SIGKILL
    owner.close()


def test_a_process_that_has_ended_is_not_mistaken_for_a_later_one_of_its_number(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    process.kill()
    process.wait()
    assert owner.is_ending()
    owner.kill()
    owner.close()

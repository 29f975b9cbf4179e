"""Cutoffs on simulated lines, with programs that hold the lines and are killed, suspended, at rest or ending."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from drivers.raspberrypi.cutoff import MotorLines, Owner, StandbyLine
from tests.drivers.raspberrypi.lines import END_S, Lines, hold_lines

FORWARD, BACKWARD, STANDBY = 17, 27, 22

pytestmark = pytest.mark.usefixtures("fake_lgpio")


def open_motor_lines(owner: int | None) -> MotorLines:
    cutoff = MotorLines([FORWARD, BACKWARD], owner)
    cutoff.open()
    cutoff.arm()
    return cutoff


def test_the_lines_of_a_dead_program_go_low_with_pull_downs(lines: Lines) -> None:
    with hold_lines(lines, FORWARD, BACKWARD) as program:
        cutoff = open_motor_lines(program.pid)
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 1
    assert cutoff.stop() is None
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 0
    assert lines.is_pulled_down(FORWARD)
    assert lines.is_pulled_down(BACKWARD)
    cutoff.close()


@pytest.mark.parametrize("is_suspended", [False, True])
def test_a_silent_program_whose_motor_turns_is_killed(*, is_suspended: bool, lines: Lines) -> None:
    with hold_lines(lines, FORWARD, BACKWARD) as program:
        cutoff = open_motor_lines(program.pid)
        if is_suspended:
            program.send_signal(signal.SIGSTOP)
        report = cutoff.stop()
        assert program.wait(END_S) == -signal.SIGKILL
    assert report == f"killed process {program.pid}, which was silent while its motors turned"
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 0
    cutoff.close()


@pytest.mark.slow
def test_a_silent_program_whose_motor_stands_is_not_killed(lines: Lines) -> None:
    with hold_lines(lines, FORWARD, BACKWARD) as program:
        cutoff = open_motor_lines(program.pid)
        cutoff.disarm()
        assert cutoff.stop() is None
        assert program.poll() is None
    cutoff.close()


FORKING = """
import os, sys
from drivers.raspberrypi import chip
chip.LINE = os.environ["FAKE_DEV"]  # the kernel's name of a line's handle
lgpio = chip.load()
lgpio.gpio_claim_output(lgpio.gpiochip_open(0), 17, 1)
if os.fork():
    os.kill(os.getpid(), 9)
print("forked", flush=True)
sys.stdin.read()
"""


def test_a_fork_of_a_killed_program_keeps_no_line(lines: Lines) -> None:
    command, pipe = [sys.executable, "-c", FORKING], subprocess.PIPE
    with subprocess.Popen(command, env=lines.environment, stdin=pipe, stdout=pipe) as program:
        assert program.stdout
        assert program.stdout.readline() == b"forked\n"
        program.wait(END_S)
        cutoff = open_motor_lines(owner=None)
        assert cutoff.stop() is None
        assert lines.level(FORWARD) == 0
        cutoff.close()


def test_a_standby_line_is_high_only_while_the_motors_are_armed(lines: Lines) -> None:
    cutoff = StandbyLine(STANDBY)
    cutoff.open()
    levels = [lines.level(STANDBY)]
    for act in (cutoff.arm, cutoff.stop, cutoff.arm, cutoff.disarm, cutoff.arm, cutoff.close):
        act()
        levels.append(lines.level(STANDBY))
    assert levels == [0, 1, 0, 1, 0, 1, 0]
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


def test_an_ending_process_with_running_threads_can_still_be_killed(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    assert not owner.is_ending()
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

"""Programs that leave a motor on in every way there is, with the guardian and its cutoffs at work on their lines."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from drivers.raspberrypi.cutoff import Owner
from tests.drivers.raspberrypi.lines import END_S, Launch, Lines, Program
from tests.drivers.raspberrypi.turning import BACKWARD, DUTY, FORWARD, STANDBY

KILLED = -signal.SIGKILL
Start = Callable[..., Program]


@pytest.fixture
def start(launch: Launch) -> Start:
    def start(cutoff: str, deed: str) -> Program:
        program = launch("tests.drivers.raspberrypi.turning", cutoff, deed, stdin=subprocess.PIPE)
        assert program.stdout
        assert program.stdout.readline() == "turning\n", program.communicate()
        return program

    return start


def over(program: Program) -> tuple[str, str]:
    """Return what it has said, once neither it nor its guardian is there any more."""
    return program.communicate(timeout=END_S)


def until(lines: Lines, gpio: int, level: int, program: Program) -> None:
    """Wait for a level; a test that waits in vain is ended by its time limit."""
    while lines.level(gpio) != level:
        with pytest.raises(subprocess.TimeoutExpired):
            program.wait(0.01)


def test_without_a_guardian_a_killed_program_leaves_its_motor_on(lines: Lines) -> None:
    """What the tests below would not see if the lines fell by themselves."""
    left = "import lgpio; lgpio.tx_pwm(lgpio.gpiochip_open(0), 17, 100, 60); import os; os.kill(os.getpid(), 9)"
    subprocess.run([sys.executable, "-c", left], env=lines.environment, timeout=END_S, check=False)
    assert lines.level(17) == 60


def test_the_lines_of_a_killed_program_go_low(start: Start, lines: Lines) -> None:
    program = start("MotorLines", "drives")
    assert lines.level(FORWARD) == DUTY
    program.kill()
    _, err = over(program)
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 0
    assert lines.is_pulled_down(FORWARD)
    assert lines.is_pulled_down(BACKWARD)
    assert err == f"guardian: the run of process {program.pid} broke off; stopped left_motor\n"


@pytest.mark.parametrize("deed", ["hangs", "halts", "leaves"])
def test_a_program_that_holds_its_lines_while_the_motor_turns_is_ended(start: Start, lines: Lines, deed: str) -> None:
    program = start("MotorLines", deed)
    out, err = over(program)
    assert (program.returncode, out) == (KILLED, "")
    assert lines.level(FORWARD) == lines.level(BACKWARD) == 0
    assert f"stopped left_motor\nguardian: ended process {program.pid}: it was silent, and held the lines" in err


@pytest.mark.parametrize("deed", ["rests", "leaves_at_rest"])
def test_a_program_whose_motors_stand_is_never_ended(start: Start, lines: Lines, deed: str) -> None:
    program = start("MotorLines", deed)
    out, err = over(program)
    assert (program.returncode, out) == (0, "lives\n")
    assert "ended" not in err
    assert lines.level(FORWARD) == 0


def test_the_lines_of_a_program_that_is_killed_at_rest_go_low_too(start: Start, lines: Lines) -> None:
    program = start("MotorLines", "rests")
    program.kill()
    _, err = over(program)
    assert "broke off; stopped left_motor" in err
    assert "ended" not in err


def test_a_program_that_ends_in_good_order_is_never_ended(start: Start) -> None:
    program = start("MotorLines", "drives")
    assert program.communicate("end\n", timeout=END_S) == ("lives\n", "")
    assert program.returncode == 0


@pytest.mark.parametrize("cutoff", ["MotorLines", "StandbyLine"])
def test_a_copy_that_a_killed_program_has_made_of_itself_keeps_no_motor_on(
    start: Start, lines: Lines, cutoff: str
) -> None:
    program = start(cutoff, "copies")
    program.wait(END_S)
    assert program.stderr
    assert "broke off; stopped left_motor" in program.stderr.readline()  # the copy lives on
    assert lines.level(FORWARD if cutoff == "MotorLines" else STANDBY) == 0


@pytest.mark.parametrize("deed", ["hangs", "rests", "leaves_at_rest"])
def test_a_standby_line_falls_and_its_program_lives_on(start: Start, lines: Lines, deed: str) -> None:
    program = start("StandbyLine", deed)
    until(lines, STANDBY, 0, program)
    out, _ = over(program)
    assert (program.returncode, out) == (0, "lives\n")


def test_a_standby_line_falls_where_its_program_is_suspended_and_rises_when_it_drives_again(
    start: Start, lines: Lines
) -> None:
    program = start("StandbyLine", "drives")
    until(lines, STANDBY, 1, program)
    program.send_signal(signal.SIGSTOP)
    until(lines, STANDBY, 0, program)
    program.send_signal(signal.SIGCONT)
    until(lines, STANDBY, 1, program)
    program.communicate("end\n", timeout=END_S)
    assert lines.level(STANDBY) == 0


def test_a_standby_line_falls_when_its_program_is_killed(start: Start, lines: Lines) -> None:
    program = start("StandbyLine", "drives")
    until(lines, STANDBY, 1, program)
    program.kill()
    over(program)
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
    """A process that waits, and whose main thread then ends before another one."""
    with subprocess.Popen([sys.executable, "-c", HALF_GONE], stdin=subprocess.PIPE, text=True) as running:
        yield running
        running.kill()


def test_one_that_waits_has_not_begun_to_end(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    assert not owner.is_ending()
    assert not owner.has_ended_within(0.0)
    owner.close()


def test_one_that_has_begun_to_end_and_has_threads_at_work_can_still_be_killed(process: subprocess.Popen[str]) -> None:
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


def test_one_that_has_gone_is_not_taken_for_whoever_gets_its_number(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    process.kill()
    process.wait()
    assert owner.is_ending()
    owner.kill()
    owner.close()


def test_one_that_is_not_there_is_reported(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    with pytest.raises(ProcessLookupError):
        Owner(process.pid)

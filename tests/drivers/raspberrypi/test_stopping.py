"""``robotcore stop`` on lines that programs have left, or have not."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.drivers.raspberrypi.lines import END_S, ROOT, Launch, Lines

MOTORS = (17, 27, 23, 24)
STANDBY = 22
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
def driving(lines: Lines, *gpios: int) -> Iterator[None]:
    """Have a program hold these lines high."""
    command = [sys.executable, "-c", DRIVING, *map(str, gpios)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=lines.environment, stdin=pipe, stdout=pipe) as program:
        assert program.stdout
        assert program.stdout.readline() == b"drives\n"
        yield
        assert program.poll() is None
        program.kill()


def stopping(launch: Launch, name: str) -> tuple[int, str, str]:
    program = launch("robotcore", "stop", "--backend", "raspberrypi", "--robot", robot(name))
    out, err = program.communicate(timeout=END_S)
    return program.returncode, out, err


@pytest.mark.parametrize(
    "name, left_high, stopped",
    [("plain", MOTORS, "left_motor, right_motor"), ("standby", [STANDBY], "left_motor and right_motor")],
)
def test_lines_that_a_dead_program_has_left_high_are_pulled_low(
    lines: Lines, launch: Launch, name: str, left_high: list[int], stopped: str
) -> None:
    with driving(lines, *left_high):
        pass
    assert [lines.level(gpio) for gpio in left_high] == [1] * len(left_high)
    assert stopping(launch, name) == (0, f"{name}: stopped {stopped}\n", "")
    assert [lines.level(gpio) for gpio in left_high] == [0] * len(left_high)
    assert all(lines.is_pulled_down(gpio) for gpio in left_high)


def test_a_program_that_lives_keeps_its_lines_and_is_named_and_all_others_are_pulled_low(
    lines: Lines, launch: Launch
) -> None:
    with driving(lines, *MOTORS):
        pass
    with driving(lines, 17):
        status, out, err = stopping(launch, "plain")
    assert (status, out) == (3, "plain: stopped right_motor\n")
    assert err.startswith("error: CANNOT STOP left_motor: GPIO 17 is held by ")
    assert err.endswith("End that program first. Cut the motors' supply\n")
    assert [lines.level(gpio) for gpio in MOTORS] == [1, 0, 0, 0]


def test_the_standby_line_of_a_guardian_that_lives_is_not_taken(lines: Lines, launch: Launch) -> None:
    with driving(lines, STANDBY):
        status, _, err = stopping(launch, "standby")
    assert status == 3
    assert err.startswith(f"error: CANNOT STOP left_motor and right_motor: GPIO {STANDBY} is held by ")

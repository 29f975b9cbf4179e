from __future__ import annotations

import signal
import sys

import pytest

from tests.system.guest.bench import MOTOR_LINES, ONWARDS, STANDBY, run_command, started
from tests.system.guest.chip import Chip
from tests.system.guest.waiting import settled

FORWARD = MOTOR_LINES["left"][0]
MOTORS = [gpio for lines in MOTOR_LINES.values() for gpio in lines]

BARE = """
import sys
from gpiozero import Motor
from gpiozero.pins.lgpio import LGPIOFactory
motor = Motor(17, 27, pin_factory=LGPIOFactory())
motor.forward()
sys.stdin.read()
"""


@pytest.fixture(params=[False, True], ids=["lines that fall when let go", "lines that keep their level"])
def is_persistent(chip: Chip, request: pytest.FixtureRequest) -> bool:
    chip.set_persistent(is_persistent=request.param)
    return bool(request.param)


def turning(chip: Chip) -> list[int]:
    """Return the motors' lines that are high, where their board is awake."""
    return [gpio for gpio in chip.high() if gpio in MOTORS]


def test_sigterm_while_driving_leaves_every_line_low(chip: Chip, is_persistent: bool) -> None:
    with started(run_command(ONWARDS, "plain")) as app:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.send_signal(signal.SIGTERM)
        assert app.wait() == 128 + signal.SIGTERM
    assert settled(chip.high, []) == []


def test_sigkill_while_driving_leaves_every_line_low_by_the_guardian(chip: Chip, is_persistent: bool) -> None:
    with started(run_command(ONWARDS, "plain")) as app:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.kill()
    assert settled(chip.high, []) == []


def test_sigkill_while_driving_leaves_the_board_asleep_by_the_guardian(chip: Chip, is_persistent: bool) -> None:
    with started(run_command(ONWARDS, "standby")) as app:
        assert settled(lambda: chip.level(STANDBY), 1) == 1
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.kill()
    assert settled(lambda: chip.level(STANDBY), 0) == 0


def test_sigstop_while_driving_leaves_every_line_low_by_the_guardian(chip: Chip) -> None:
    with started(run_command(ONWARDS, "plain")) as app:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        app.send_signal(signal.SIGSTOP)
        assert settled(chip.high, []) == []


def test_without_a_guardian_sigkill_leaves_a_line_that_keeps_its_level_high(chip: Chip, is_persistent: bool) -> None:
    with started([sys.executable, "-c", BARE]) as program:
        assert settled(lambda: chip.level(FORWARD), 1) == 1
        program.kill()
        program.wait()
    left = [FORWARD] if is_persistent else []
    assert settled(chip.high, left) == left

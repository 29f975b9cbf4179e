"""A line sends no more than its baud rate allows, and only the newest command."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from drivers.serial.line import BITS_PER_BYTE, PERIOD_S, Line
from robotcore.hal.clock import SteppedClock
from tests.doubles.serial.board import Powered
from tests.doubles.serial.line import NumberingProtocol, ReceivedFrame, Wire
from tests.doubles.serial.pty import Pty

SIZE = 8
COMMAND_PERIOD_S = 0.005
DURATION_S = 2.0
TURN_S = 2 * PERIOD_S
"""The longest delay of a command by the test: the line and the double run in turn."""


@dataclass
class Driving:
    """The results of sending commands with the numbers 1, 2 and so on, two hundred a second.

    sent: the time of setting each command, by number.
    received: the commands that arrived at the double.
    """

    baud: int
    sent: dict[int, float] = field(default_factory=dict)
    received: list[ReceivedFrame] = field(default_factory=list)

    @property
    def frame_s(self) -> float:
        return SIZE * BITS_PER_BYTE / self.baud

    def newest_at(self, time: float) -> int:
        return max((number for number, at in self.sent.items() if at <= time), default=0)


@pytest.fixture(params=[9600, 57600, 115200], ids="{} baud".format)
def driving(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Driving]:
    driving = Driving(request.param)
    clock = SteppedClock(1000, lambda _steps: None)
    wire, protocol = Wire(driving.baud, SIZE), NumberingProtocol(driving.baud, SIZE)
    with Pty(tmp_path) as pty:
        Powered(wire, pty, clock)
        line = Line(str(pty.path), protocol, clock)
        line.open("wheel", 1.0)
        while clock.now() < DURATION_S:
            number = len(driving.sent) + 1
            driving.sent[number] = clock.now()
            protocol.set(number, clock.now())
            clock.sleep_until(clock.now() + COMMAND_PERIOD_S)
        line.close()
        driving.received = wire.received
        yield driving


def test_no_command_waits_for_another_one_on_the_wire(driving: Driving) -> None:
    assert max(frame.waited for frame in driving.received) <= TURN_S


def test_only_the_newest_command_is_sent(driving: Driving) -> None:
    assert all(frame.number >= driving.newest_at(frame.at - TURN_S - PERIOD_S) for frame in driving.received)


def test_no_command_is_sent_twice_or_after_a_newer_one(driving: Driving) -> None:
    numbers = [frame.number for frame in driving.received]
    assert numbers == sorted(set(numbers))


def test_the_age_of_arriving_commands_is_bounded(driving: Driving) -> None:
    bound = COMMAND_PERIOD_S + driving.frame_s + 2 * TURN_S
    assert max(frame.left_at - driving.sent[frame.number] for frame in driving.received) <= bound


def test_a_fast_line_sends_every_command_and_a_slow_line_is_never_idle(driving: Driving) -> None:
    most = DURATION_S / max(COMMAND_PERIOD_S, driving.frame_s + PERIOD_S)
    assert len(driving.received) >= 0.95 * most

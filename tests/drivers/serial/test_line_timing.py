"""A line sends no more than it carries, and only the newest command."""

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
TOLD_EVERY_S = 0.005
LASTING_S = 2.0
LATER_S = 2 * PERIOD_S
"""Line and far end take turns, so that a command arrives a turn later."""


@dataclass
class Driving:
    """Numbered commands, two hundred a second from 1 on, and those that arrived."""

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
        while clock.now() < LASTING_S:
            number = len(driving.sent) + 1
            driving.sent[number] = clock.now()
            protocol.set(number, clock.now())
            clock.sleep_until(clock.now() + TOLD_EVERY_S)
        line.close()
        driving.received = wire.received
        yield driving


def test_no_command_waits_for_another_one_on_the_wire(driving: Driving) -> None:
    assert max(frame.waited for frame in driving.received) <= LATER_S


def test_only_the_newest_command_is_sent(driving: Driving) -> None:
    assert all(frame.number >= driving.newest_at(frame.at - LATER_S - PERIOD_S) for frame in driving.received)


def test_no_command_is_sent_twice_or_after_a_newer_one(driving: Driving) -> None:
    numbers = [frame.number for frame in driving.received]
    assert numbers == sorted(set(numbers))


def test_the_age_of_arriving_commands_is_bounded(driving: Driving) -> None:
    bound = TOLD_EVERY_S + driving.frame_s + 2 * LATER_S
    assert max(frame.left_at - driving.sent[frame.number] for frame in driving.received) <= bound


def test_a_line_that_carries_every_command_sends_every_one_and_a_slower_one_is_never_idle(driving: Driving) -> None:
    most = LASTING_S / max(TOLD_EVERY_S, driving.frame_s + PERIOD_S)
    assert len(driving.received) >= 0.95 * most

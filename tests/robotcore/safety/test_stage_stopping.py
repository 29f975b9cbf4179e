"""A stop wins, whoever is in the middle of what."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import suppress

import pytest

from robotcore.clock import MonotonicClock, SteppedClock, TickClock
from robotcore.drive import Wheels
from robotcore.errors import DeviceError, EmergencyStopError
from robotcore.safety import Latch, SafetyStage
from tests.robotcore.fakes import NullMotor


class Pressing:
    """A rule in whose middle somebody presses the e-stop."""

    cause = "pressing"

    def __init__(self, latch: Latch) -> None:
        self._latch = latch
        self.is_pressed = False

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        if not self.is_pressed:
            return asked
        self._latch.set(EmergencyStopError("now"))
        return Wheels(asked.left / 2, asked.right / 2)


def test_an_e_stop_between_the_check_and_the_command_wins() -> None:
    latch, left, right = Latch(), NullMotor("left"), NullMotor("right")
    rule = Pressing(latch)
    stage = SafetyStage(TickClock(SteppedClock(20, lambda _: None)), left, right, [rule], 0.125, latch)
    stage.ask(Wheels(2.0, 2.0))
    stage.commit()
    rule.is_pressed = True
    stage.commit()
    assert (left.sent[-1], right.sent[-1]) == (0.0, 0.0)


@pytest.fixture
def clock() -> Iterator[MonotonicClock]:
    real = MonotonicClock()
    yield real
    with suppress(DeviceError):  # what the deadman could not do in its thread
        real.close()


def test_where_the_stop_of_one_motor_hangs_the_deadman_stops_the_other(clock: MonotonicClock) -> None:
    left, right = NullMotor("left"), NullMotor("right")
    let_go, stopped = threading.Event(), threading.Event()

    def hang(rad_s: float) -> None:
        if rad_s == 0:
            let_go.wait()

    left.on_command = hang
    right.on_command = lambda rad_s: stopped.set() if rad_s == 0 else None

    def drive() -> None:
        stage = SafetyStage(clock, left, right, [], 0.1)
        stage.ask(Wheels(2.0, 2.0))
        stage.commit()
        stage.stop()

    driving = threading.Thread(target=drive)
    driving.start()
    is_stopped = stopped.wait(30)
    is_hung = driving.is_alive()
    let_go.set()
    driving.join()
    assert is_stopped
    assert is_hung

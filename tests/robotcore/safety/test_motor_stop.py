from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from robotcore.errors import DeviceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety import StopGroup
from robotcore.safety.motor_stop import MotorStop
from robotcore.safety.reserve import Reserve
from tests.robotcore.fakes import NullMotor


class HungMotor(NullMotor):
    """A motor that does not come back from being told anything, until it is let go."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.let_go = threading.Event()
        self.on_command = lambda _: self.let_go.wait()


@pytest.fixture
def reserve() -> Iterator[Reserve]:
    """Threads enough for two motors, held from the start."""
    reserve = Reserve(MonotonicClock())
    reserve.hold(threads=2)
    yield reserve
    reserve.close()


@pytest.fixture
def hung() -> Iterator[HungMotor]:
    motor = HungMotor("left_motor")
    yield motor
    motor.let_go.set()


def test_stops_every_motor() -> None:
    left, right = NullMotor("left_motor"), NullMotor("right_motor")
    StopGroup.on(left, right).apply()
    assert (left.sent, right.sent) == ([0.0], [0.0])


def test_one_that_fails_keeps_the_other_from_nothing_and_is_reported() -> None:
    left, right = NullMotor("left_motor"), NullMotor("right_motor")
    left.is_broken = True
    with pytest.raises(DeviceError, match="left_motor: no current"):
        StopGroup.on(left, right).apply()
    assert right.sent == [0.0]


def test_one_that_hangs_holds_up_nobody_who_stops_them_apart(hung: HungMotor, reserve: Reserve) -> None:
    right = NullMotor("right_motor")
    brakes = StopGroup.on(hung, right, reserve=reserve)
    (failure,) = brakes.apply_apart()
    assert "left_motor: has not stopped within 0.2 s" in str(failure)
    assert right.sent == [0.0]
    assert brakes.are_hung


def test_a_stop_that_is_under_way_is_waited_for(hung: HungMotor, reserve: Reserve) -> None:
    brake = MotorStop(hung, reserve)
    tell = brake.begin()
    threading.Timer(0.02, hung.let_go.set).start()
    brake.apply()
    assert tell() is None
    assert hung.sent == [0.0, 0.0]


def test_from_another_thread_they_are_stopped_apart(hung: HungMotor, reserve: Reserve) -> None:
    right = NullMotor("right_motor")
    brakes, raised = StopGroup.on(hung, right, reserve=reserve), []

    def stop() -> None:
        try:
            brakes.apply()
        except DeviceError as error:
            raised.append(error.device)

    thread = threading.Thread(target=stop)
    thread.start()
    thread.join()
    assert raised == ["left_motor"]
    assert right.sent == [0.0]


def test_a_stop_that_hangs_is_not_begun_again_and_is_reported_at_once(hung: HungMotor, reserve: Reserve) -> None:
    brakes = StopGroup.on(hung, reserve=reserve)
    brakes.apply_apart()
    assert brakes.apply_apart()
    with pytest.raises(DeviceError, match="has not stopped"):
        brakes.apply()
    assert hung.received == [0.0]


def test_one_that_comes_back_can_be_stopped_again(hung: HungMotor, reserve: Reserve) -> None:
    brakes = StopGroup.on(hung, reserve=reserve)
    brakes.apply_apart()
    hung.let_go.set()
    while brakes.are_hung:
        pass
    assert not brakes.apply_apart()
    assert hung.sent == [0.0, 0.0]


def test_some_of_them_share_what_is_known_of_all(hung: HungMotor, reserve: Reserve) -> None:
    right = NullMotor("right_motor")
    brakes = StopGroup.on(hung, right, reserve=reserve)
    brakes.apply_apart()
    assert brakes.of(hung).are_hung
    assert not brakes.of(right).are_hung


def test_a_stop_that_raises_what_ends_programs_is_a_failure_of_its_motor(reserve: Reserve) -> None:
    motor = NullMotor("left_motor")

    def leave(rad_s: float) -> None:
        raise SystemExit

    motor.on_command = leave
    (failure,) = StopGroup.on(motor, reserve=reserve).apply_apart()
    assert isinstance(failure, DeviceError)
    assert failure.device == "left_motor"


def test_a_stop_for_which_memory_is_refused_is_made_again(reserve: Reserve) -> None:
    motor, refusals = NullMotor("left_motor"), iter([MemoryError(), MemoryError()])

    def refuse(rad_s: float) -> None:
        for refusal in refusals:
            raise refusal

    motor.on_command = refuse
    assert StopGroup.on(motor, reserve=reserve).apply_apart() == []
    assert motor.sent == [0.0]

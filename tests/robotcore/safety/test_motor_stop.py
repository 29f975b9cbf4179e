from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from robotcore.errors import DeviceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.motor_stop import MotorStop, StopGroup
from robotcore.safety.thread_reserve import Reserve
from tests.robotcore.fakes import NullMotor
from tests.texts import CheckText, Raises


class HungMotor(NullMotor):
    """A motor whose commands do not return until the test sets ``release``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.release = threading.Event()
        self.on_command = lambda _: self.release.wait()


@pytest.fixture
def reserve() -> Iterator[Reserve]:
    """A reserve with a thread for each of two motors."""
    reserve = Reserve(MonotonicClock())
    reserve.hold(threads=2)
    yield reserve
    reserve.close()


@pytest.fixture
def hung() -> Iterator[HungMotor]:
    motor = HungMotor("left_motor")
    yield motor
    motor.release.set()


def test_failure_of_one_motor_is_raised_after_the_other_stopped() -> None:
    left, right = NullMotor("left_motor"), NullMotor("right_motor")
    left.is_broken = True
    with pytest.raises(DeviceError) as raised:
        StopGroup.create(left, right).apply()
    assert raised.value.device == "left_motor"
    assert right.sent == [0.0]


def test_motor_that_hangs_does_not_delay_the_others(hung: HungMotor, reserve: Reserve, check_text: CheckText) -> None:
    right = NullMotor("right_motor")
    stops = StopGroup.create(hung, right, reserve=reserve)
    (failure,) = stops.apply_apart()
    assert isinstance(failure, DeviceError)
    assert (failure.kind, failure.device, failure.fields["within_s"]) == ("stop-timeout", "left_motor", 0.2)
    check_text(failure)
    assert right.sent == [0.0]
    assert stops.are_hung


def test_stop_waits_for_one_that_is_under_way(hung: HungMotor, reserve: Reserve) -> None:
    stop = MotorStop(hung, reserve)
    wait = stop.begin()
    threading.Timer(0.02, hung.release.set).start()
    stop.apply()
    assert wait() is None
    assert hung.sent == [0.0, 0.0]


def test_another_thread_stops_each_motor_in_its_own_thread(hung: HungMotor, reserve: Reserve) -> None:
    right = NullMotor("right_motor")
    stops, raised = StopGroup.create(hung, right, reserve=reserve), []

    def stop() -> None:
        try:
            stops.apply()
        except DeviceError as error:
            raised.append(error.device)

    thread = threading.Thread(target=stop)
    thread.start()
    thread.join()
    assert raised == ["left_motor"]
    assert right.sent == [0.0]


def test_stop_that_hangs_is_not_repeated_and_is_reported_at_once(
    hung: HungMotor, reserve: Reserve, raises: Raises
) -> None:
    stops = StopGroup.create(hung, reserve=reserve)
    stops.apply_apart()
    assert stops.apply_apart()
    with raises(DeviceError, "stop-timeout"):
        stops.apply()
    assert hung.received == [0.0]


def test_motor_that_returned_can_be_stopped_again(hung: HungMotor, reserve: Reserve) -> None:
    stops = StopGroup.create(hung, reserve=reserve)
    stops.apply_apart()
    hung.release.set()
    while stops.are_hung:
        pass
    assert not stops.apply_apart()
    assert hung.sent == [0.0, 0.0]


def test_part_of_a_group_shares_its_state(hung: HungMotor, reserve: Reserve) -> None:
    right = NullMotor("right_motor")
    stops = StopGroup.create(hung, right, reserve=reserve)
    stops.apply_apart()
    assert stops.select(hung).are_hung
    assert not stops.select(right).are_hung


def test_stop_that_raises_system_exit_is_a_failure_of_its_motor(reserve: Reserve) -> None:
    motor = NullMotor("left_motor")

    def leave(rad_s: float) -> None:
        raise SystemExit

    motor.on_command = leave
    (failure,) = StopGroup.create(motor, reserve=reserve).apply_apart()
    assert isinstance(failure, DeviceError)
    assert (failure.kind, failure.device) == ("stop-raised", "left_motor")


def test_stop_that_runs_out_of_memory_is_repeated(reserve: Reserve) -> None:
    motor, refusals = NullMotor("left_motor"), iter([MemoryError(), MemoryError()])

    def refuse(rad_s: float) -> None:
        for refusal in refusals:
            raise refusal

    motor.on_command = refuse
    assert StopGroup.create(motor, reserve=reserve).apply_apart() == []
    assert motor.sent == [0.0]

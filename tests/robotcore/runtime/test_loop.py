from __future__ import annotations

import os
from collections.abc import Callable

import pytest

from robotcore.errors import BehaviourError, UsageError
from robotcore.geometry import Wheels
from robotcore.hal.robot import Robot
from robotcore.hal.value_log import LoggedValue
from robotcore.runtime.behaviour import Status
from robotcore.runtime.loop import Loop
from robotcore.runtime.result import Outcome
from robotcore.runtime.trace import TickRecord
from tests.robotcore.fakes import FunctionApp, Rig
from tests.texts import Raises


def loop_of(
    rig: Rig,
    step: Callable[[Robot], Status | None],
    timeout: float = 10.0,
    observer: Callable[[TickRecord], None] = lambda _: None,
) -> Loop:
    return Loop(rig.assembled, FunctionApp(step), rig.rate_hz, timeout, [observer])


def forever(robot: Robot) -> Status:
    robot.drive.set_wheels(2.0, 2.0)
    return Status.RUNNING


def test_one_period_passes_between_two_ticks_and_a_success_in_the_last_tick_counts() -> None:
    rig, times = Rig(rate_hz=7), list[float]()

    def drive_a_while(robot: Robot) -> Status:
        forever(robot)
        return Status.SUCCESS if len(times) == 3 else Status.RUNNING

    assert loop_of(rig, drive_a_while, 3 / 7, lambda record: times.append(record.time)).run() is Outcome.SUCCESS
    assert [time * 245 for time in times] == [0, 35, 70, 105]
    assert sum(rig.steps) == 105


def test_command_is_sent_after_the_step() -> None:
    rig = Rig()
    sent_by_then: list[int] = []

    def drive(robot: Robot) -> Status:
        robot.drive.set_wheels(9.0, 9.0)
        robot.drive.set_wheels(2.0, 1.0)
        sent_by_then.append(len(rig.left.sent))
        return Status.RUNNING

    loop_of(rig, drive).tick()
    assert sent_by_then == [0]
    assert (rig.left.sent, rig.right.sent) == ([2.0], [1.0])


def test_record_has_the_state_and_both_commands() -> None:
    rig, records = Rig(), list[TickRecord]()
    rig.nose.distance = 0.05
    loop_of(rig, forever, observer=records.append).tick()
    (record,) = records
    assert (record.tick, record.time, record.state) == (0, 0.0, "start")
    assert (record.asked, record.sent) == (Wheels(2.0, 2.0), Wheels(0.0, 0.0))
    assert [each.cause for each in record.interventions] == ["range guard"]


def test_overruns_are_counted_and_missed_ticks_are_left_out() -> None:
    rig = Rig()

    def stall(robot: Robot) -> Status:
        if rig.assembled.clock.tick == 2:
            rig.clock.sleep_until(rig.clock.now() + 0.12)
        return Status.RUNNING

    times: list[float] = []
    loop = loop_of(rig, stall, timeout=0.4, observer=lambda record: times.append(record.time))
    loop.run()
    assert loop.overruns == 1
    assert times == pytest.approx([0.0, 0.05, 0.1, 0.22, 0.27, 0.32, 0.37, 0.42], abs=1 / 240)


def test_a_state_that_is_no_text_is_an_error_of_the_app(raises: Raises) -> None:
    rig = Rig()
    loop = loop_of(rig, lambda _: Status.RUNNING)
    loop.behaviour.state = None  # type: ignore[assignment]
    with raises(BehaviourError, "state-not-a-text"):
        loop.tick()


def test_a_reason_that_is_no_text_is_an_error_of_the_app(raises: Raises) -> None:
    loop = loop_of(Rig(), lambda _: Status.FAILURE)
    loop.behaviour.reason = ValueError("too dark")  # type: ignore[assignment]
    with raises(BehaviourError, "reason-not-a-text"):
        loop.run()


@pytest.mark.parametrize("name", ["state", "reason"])
def test_a_text_that_is_not_utf_8_is_an_error_of_the_app(name: str, raises: Raises) -> None:
    loop = loop_of(Rig(), lambda _: Status.FAILURE)
    setattr(loop.behaviour, name, os.fsdecode(b"\xff.txt"))
    with raises(BehaviourError, f"{name}-not-encodable"):
        loop.run()


class Unprintable:
    """An object whose ``__repr__`` raises an exception."""

    def __repr__(self) -> str:
        raise RuntimeError


def test_a_reason_that_cannot_be_printed_is_an_error_of_the_app() -> None:
    loop = loop_of(Rig(), lambda _: Status.FAILURE)
    loop.behaviour.reason = Unprintable()  # type: ignore[assignment]
    with pytest.raises(BehaviourError) as caught:
        loop.run()
    assert caught.value.kind == "reason-not-a-text"


def test_a_status_that_cannot_be_printed_is_an_error_of_the_app() -> None:
    with pytest.raises(BehaviourError) as caught:
        loop_of(Rig(), lambda _: Unprintable()).run()  # type: ignore[arg-type,return-value]
    assert caught.value.kind == "not-a-status"


@pytest.mark.parametrize("returned", [None, True, "success"])
def test_step_must_return_a_status(returned: object, raises: Raises) -> None:
    with raises(BehaviourError, "not-a-status"):
        loop_of(Rig(), lambda _: returned).run()  # type: ignore[arg-type,return-value]


@pytest.mark.parametrize(
    "step, kind", [(0, "method-hidden"), (lambda: None, "wrong-parameters")], ids=["hidden", "self"]
)
def test_a_step_that_cannot_be_called_is_named(step: object, kind: str, raises: Raises) -> None:
    loop = loop_of(Rig(), forever)
    loop.behaviour.step = step  # type: ignore[method-assign,assignment]
    with raises(BehaviourError, kind, method="step"):
        loop.run()


def test_record_of_a_tick_has_the_values_that_the_app_logged_in_it_also_before_an_exception() -> None:
    rig, records = Rig(), list[TickRecord]()

    def log_and_fail(robot: Robot) -> Status:
        robot.log("number", len(records))
        if len(records) == 2:
            raise KeyError
        return Status.RUNNING if len(records) else forever(robot)

    with pytest.raises(BehaviourError):
        loop_of(rig, log_and_fail, observer=records.append).run()
    assert [record.logged for record in records] == [{"number": LoggedValue(number)} for number in range(3)]


def test_invalid_value_in_the_log_ends_the_run(raises: Raises) -> None:
    def log(robot: Robot) -> Status:
        robot.log("place", None)  # type: ignore[arg-type]
        return Status.RUNNING

    with raises(BehaviourError) as raised:
        loop_of(Rig(), log).run()
    assert isinstance(raised.value.__cause__, UsageError)

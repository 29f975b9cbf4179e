"""Several clients, those that fall silent, and what is no request."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.zmq.talking import EXECUTED, WAIT, Talker, await_time, talking

STOPPED = {"ret": [0]}


@pytest.fixture
def port() -> Iterator[int]:
    with Double(default_scene()) as double:
        yield double.zmq_port


@pytest.fixture
def pair(port: int) -> Iterator[tuple[Talker, ...]]:
    with talking(port, "one", "other") as talkers:
        yield talkers


def time_of(talker: Talker) -> float:
    return float(talker.call("sim.getSimulationTime")["ret"][0])


def test_a_step_waits_for_all_who_step(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    for each in pair:
        assert each.call("sim.setStepping", True) == {"ret": [0]}
    one.call("sim.startSimulation")
    assert one.call("sim.step")["func"] == WAIT
    assert one.say(EXECUTED)["func"] == WAIT
    assert time_of(other) == 0.0
    assert other.done("sim.step") == {"ret": {}}
    assert one.say(EXECUTED) == {"ret": {}}
    assert time_of(one) == 0.05


def test_whatever_is_said_within_a_call_that_waits_is_its_continuation(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    assert one.call("sim.step")["func"] == WAIT
    assert one.call("sim.getSimulationTime")["func"] == WAIT
    assert other.done("sim.step") == {"ret": {}}
    assert one.call("sim.getSimulationTime") == {"ret": {}}
    assert time_of(one) == 0.05


def test_time_goes_on_when_one_of_two_no_longer_steps(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    one.call("sim.step")
    assert other.call("sim.setStepping", False) == {"ret": [1]}
    assert one.finish(one.say(EXECUTED)) == {"ret": {}}


def test_levels_count_per_client(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    assert [one.call("sim.setStepping", True)["ret"][0] for _ in range(3)] == [0, 1, 2]
    assert other.call("sim.setStepping", False) == {"ret": [0]}
    assert [one.call("sim.setStepping", False)["ret"][0] for _ in range(4)] == [3, 2, 1, 0]


def test_a_silent_client_is_dropped_after_the_time_that_it_named(port: int) -> None:
    with talking(port, "silent", "alive") as (silent, alive):
        silent.call("sim.setStepping", True, ver=2, lang="python", timeout=0.2)
        silent.call("sim.startSimulation")
        await_time(alive)
        assert silent.call("sim.setStepping", True) == {"ret": [0]}


def test_who_leaves_holds_nothing(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    one.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    assert one.call("_*end*_") == {}
    await_time(other)


def test_a_stop_by_another_ends_a_step_and_all_stepping(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    one.call("sim.step")
    assert other.done("sim.stopSimulation", True) == {"ret": {}}
    assert one.finish(one.say(EXECUTED)) == {"ret": {}}
    assert one.call("sim.getSimulationState") == STOPPED
    assert [each.call("sim.setStepping", True) for each in pair] == [{"ret": [0]}, {"ret": [0]}]


def test_a_step_while_stopped_returns(pair: tuple[Talker, ...]) -> None:
    pair[0].call("sim.setStepping", True)
    assert pair[0].done("sim.step") == {"ret": {}}
    assert time_of(pair[0]) == 0.0


def test_what_is_no_request_gets_an_answer_and_harms_nobody(pair: tuple[Talker, ...]) -> None:
    one, other = pair
    assert "err" in one.say_bytes(b"\xff\x00nonsense")
    assert other.call("sim.getSimulationState") == STOPPED
    assert other.call("sim.getObject", 5) == {"err": "354: in sim.getObject: argument 1 is not a string/buffer."}


def test_a_client_of_the_first_protocol_is_reported_to_it(pair: tuple[Talker, ...]) -> None:
    from tests.doubles.coppeliasim.zmq.wire import dumps

    assert pair[0].say_bytes(dumps({"func": "sim.getSimulationState", "args": []}))["success"] is False


def test_a_function_that_the_double_lacks_is_refused_by_name(pair: tuple[Talker, ...]) -> None:
    assert "the double of the simulator lacks" in pair[0].call("sim.getObjectUid", 1)["err"]
    assert pair[0].call("sim.fly", 1) == {"err": "No such function: sim.fly"}


def test_a_legacy_service_is_started_over_it(pair: tuple[Talker, ...]) -> None:
    one, _ = pair
    one.call("sim.startSimulation")
    assert one.call("simRemoteApi.start", 0) == {"ret": [1]}
    one.done("sim.stopSimulation", True)

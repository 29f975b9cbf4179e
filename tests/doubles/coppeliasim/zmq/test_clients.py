"""Tests with several clients, silent clients, and invalid requests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.zmq.raw_client import EXECUTED, WAIT, RawClient, await_time, connect_clients

STOPPED = {"ret": [0]}


@pytest.fixture
def port() -> Iterator[int]:
    with Double(default_scene()) as double:
        yield double.zmq_port


@pytest.fixture
def pair(port: int) -> Iterator[tuple[RawClient, ...]]:
    with connect_clients(port, "one", "other") as talkers:
        yield talkers


def time_of(talker: RawClient) -> float:
    return float(talker.call("sim.getSimulationTime")["ret"][0])


def test_step_waits_for_all_stepping_clients(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    for each in pair:
        assert each.call("sim.setStepping", True) == {"ret": [0]}
    one.call("sim.startSimulation")
    assert one.call("sim.step")["func"] == WAIT
    assert one.exchange(EXECUTED)["func"] == WAIT
    assert time_of(other) == 0.0
    assert other.call_and_wait("sim.step") == {"ret": {}}
    assert one.exchange(EXECUTED) == {"ret": {}}
    assert time_of(one) == 0.05


def test_message_during_a_waiting_call_continues_it(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    assert one.call("sim.step")["func"] == WAIT
    assert one.call("sim.getSimulationTime")["func"] == WAIT
    assert other.call_and_wait("sim.step") == {"ret": {}}
    assert one.call("sim.getSimulationTime") == {"ret": {}}
    assert time_of(one) == 0.05


def test_time_advances_after_one_of_two_clients_ends_stepping(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    one.call("sim.step")
    assert other.call("sim.setStepping", False) == {"ret": [1]}
    assert one.finish(one.exchange(EXECUTED)) == {"ret": {}}


def test_each_client_has_its_level(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    assert [one.call("sim.setStepping", True)["ret"][0] for _ in range(3)] == [0, 1, 2]
    assert other.call("sim.setStepping", False) == {"ret": [0]}
    assert [one.call("sim.setStepping", False)["ret"][0] for _ in range(4)] == [3, 2, 1, 0]


def test_silent_client_is_dropped_after_its_time_limit(port: int) -> None:
    with connect_clients(port, "silent", "alive") as (silent, alive):
        silent.call("sim.setStepping", True, ver=2, lang="python", timeout=0.2)
        silent.call("sim.startSimulation")
        await_time(alive)
        assert silent.call("sim.setStepping", True) == {"ret": [0]}


def test_client_that_leaves_holds_nothing(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    one.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    assert one.call("_*end*_") == {}
    await_time(other)


def test_stop_by_another_client_ends_steps(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    one.call("sim.step")
    assert other.call_and_wait("sim.stopSimulation", True) == {"ret": {}}
    assert one.finish(one.exchange(EXECUTED)) == {"ret": {}}
    assert one.call("sim.getSimulationState") == STOPPED
    assert [each.call("sim.setStepping", True) for each in pair] == [{"ret": [0]}, {"ret": [0]}]


def test_step_while_stopped_returns(pair: tuple[RawClient, ...]) -> None:
    pair[0].call("sim.setStepping", True)
    assert pair[0].call_and_wait("sim.step") == {"ret": {}}
    assert time_of(pair[0]) == 0.0


def test_invalid_request_is_answered(pair: tuple[RawClient, ...]) -> None:
    one, other = pair
    assert "err" in one.exchange_bytes(b"\xff\x00nonsense")
    assert other.call("sim.getSimulationState") == STOPPED
    assert other.call("sim.getObject", 5) == {"err": "354: in sim.getObject: argument 1 is not a string/buffer."}


def test_client_of_the_first_protocol_gets_an_error(pair: tuple[RawClient, ...]) -> None:
    from tests.doubles.coppeliasim.zmq.wire import dumps

    assert pair[0].exchange_bytes(dumps({"func": "sim.getSimulationState", "args": []}))["success"] is False


def test_missing_function_is_refused_by_name(pair: tuple[RawClient, ...]) -> None:
    assert "the double of the simulator lacks" in pair[0].call("sim.getObjectUid", 1)["err"]
    assert pair[0].call("sim.fly", 1) == {"err": "No such function: sim.fly"}


def test_legacy_service_is_started(pair: tuple[RawClient, ...]) -> None:
    one, _ = pair
    one.call("sim.startSimulation")
    assert one.call("simRemoteApi.start", 0) == {"ret": [1]}
    one.call_and_wait("sim.stopSimulation", True)

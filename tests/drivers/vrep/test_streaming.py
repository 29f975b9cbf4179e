"""Tests of a simulation without lockstep: its newest values and its time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from drivers.vrep.streaming import StreamReader
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import (
    RefusedError,
    RemoteApiError,
    ServerLostError,
    ServerTimeoutError,
    SimulationHaltedError,
)
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.legacy.faults import Hang
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.texts import CheckText, Raises

LEFT = 182
PATIENCE_S = 10.0
TIMEOUT_S = 1.5
"""The time limit of requests, in seconds. It is long enough for a busy machine."""


@pytest.fixture
def reader(server: LegacyServer) -> Iterator[StreamReader]:
    with StreamReader.open("127.0.0.1", server.port, TIMEOUT_S) as reader:
        reader.start()
        yield reader


def wait_for(condition: Callable[[], object]) -> None:
    clock = MonotonicClock()
    while not condition():
        assert clock.now() < PATIENCE_S
        clock.sleep_until(clock.now() + 0.005)


def await_error(reader: StreamReader) -> RemoteApiError:
    """Read the time until it raises an error, and return the error."""
    clock = MonotonicClock()
    while clock.now() < PATIENCE_S:
        try:
            reader.time_s  # noqa: B018
        except RemoteApiError as error:
            return error
        clock.sleep_until(clock.now() + 0.005)
    pytest.fail("the time is still readable")


def test_time_and_values_advance_by_themselves(reader: StreamReader) -> None:
    reader.stream(requests.joint_position(LEFT))
    reader.post(requests.joint_target_velocity(LEFT, 2.0))
    wait_for(lambda: reader.time_s > 0.3)
    first = reader.newest(requests.joint_position(LEFT))
    wait_for(lambda: reader.newest(requests.joint_position(LEFT)).time_s > first.time_s)
    before = reader.time_s
    second = reader.newest(requests.joint_position(LEFT))
    assert second.value - first.value == pytest.approx(2.0 * (second.time_s - first.time_s), abs=1e-5)
    assert before <= second.time_s <= reader.time_s


def test_call_does_not_end_a_stream(reader: StreamReader) -> None:
    reader.stream(requests.joint_position(LEFT))
    reader.call(requests.joint_position(LEFT))
    reader.call(requests.CLOCK)
    before = reader.newest(requests.joint_position(LEFT)).time_s
    wait_for(lambda: reader.newest(requests.joint_position(LEFT)).time_s > before)


def test_refused_requests_are_errors(reader: StreamReader, raises: Raises) -> None:
    with raises(RefusedError, action="find '/nope'"):
        reader.call(requests.object_handle("/nope"))
    with raises(RefusedError, action="read the position of joint 99999"):
        reader.stream(requests.joint_position(99999))

    def is_refused() -> bool:
        try:
            reader.post(requests.joint_target_velocity(99999, 1.0))
        except RefusedError:
            return True
        return False

    wait_for(is_refused)


def test_each_call_fails_after_the_connection_is_lost(reader: StreamReader, server: LegacyServer) -> None:
    server.service.disconnect()
    assert isinstance(await_error(reader), ServerLostError)
    with pytest.raises(ServerLostError):
        reader.post(requests.joint_target_velocity(LEFT, 1.0))
    with pytest.raises(ServerLostError):
        reader.call(requests.object_handle("/rover"))


@pytest.mark.slow
def test_server_that_hangs_times_out(reader: StreamReader, server: LegacyServer) -> None:
    hang = Hang()
    server.service.fail(hang)
    assert isinstance(await_error(reader), ServerTimeoutError)
    hang.release()


@pytest.mark.slow
def test_simulator_that_does_nothing_times_out(
    reader: StreamReader, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
    error = await_error(reader)
    assert (type(error), error.kind) == (ServerTimeoutError, "simulator-busy")
    check_text(error)


def test_stop_and_start_wait_for_the_state(reader: StreamReader) -> None:
    wait_for(lambda: reader.time_s > 0.2)
    reader.stop()
    assert not reader.server.is_running
    reader.start()
    assert reader.time_s < 1.0


def test_time_of_a_stopped_simulation_is_an_error(reader: StreamReader, simulator: Simulator) -> None:
    with simulator.lock:
        simulator.stop()
    assert isinstance(await_error(reader), SimulationHaltedError)


def test_unnoticed_restart_of_the_simulation_is_an_error(reader: StreamReader, simulator: Simulator) -> None:
    wait_for(lambda: reader.time_s > 0.3)
    with simulator.lock:
        simulator.stop()
        simulator.start()
    kinds = [await_error(reader).kind for _ in range(2)]
    assert kinds == ["simulation-stopped"] * 2, "each read must raise, because several threads read"


def test_last_command_is_done_before_disconnecting(server: LegacyServer, simulator: Simulator) -> None:
    with StreamReader.open("127.0.0.1", server.port) as reader:
        reader.post(requests.joint_target_velocity(LEFT, 3.0))
        reader.post(requests.joint_target_velocity(LEFT, 0.0))
    assert simulator.graph[LEFT].target_velocity == 0.0  # type: ignore[attr-defined]


def test_server_of_a_scene_ends_with_its_simulation(server: LegacyServer, simulator: Simulator) -> None:
    with simulator.lock:
        simulator.start()
    service = server.start_temporary()
    with StreamReader.open("127.0.0.1", service.port, TIMEOUT_S) as reader:
        with simulator.lock:
            simulator.stop()
        assert isinstance(await_error(reader), (ServerLostError, SimulationHaltedError))

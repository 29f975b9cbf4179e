"""A simulator that runs by itself: its newest values and its time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from drivers.vrep.streaming import StreamReader
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import (
    RefusedError,
    RemoteApiError,
    ServerHangsError,
    ServerLostError,
    SimulationHaltedError,
)
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.legacy.faults import Hang
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.simulator import Simulator

LEFT = 182
PATIENCE_S = 10.0
TIMEOUT_S = 1.5
"""Long enough for a server on a machine that has other things to do."""


@pytest.fixture
def following(server: LegacyServer) -> Iterator[StreamReader]:
    with StreamReader.to("127.0.0.1", server.port, TIMEOUT_S) as following:
        following.start()
        yield following


def wait_for(is_so: Callable[[], object]) -> None:
    clock = MonotonicClock()
    while not is_so():
        assert clock.now() < PATIENCE_S
        clock.sleep_until(clock.now() + 0.005)


def error_of(following: StreamReader) -> RemoteApiError:
    """Return what asking for the time raises, once it does."""
    clock = MonotonicClock()
    while clock.now() < PATIENCE_S:
        try:
            following.time_s  # noqa: B018
        except RemoteApiError as error:
            return error
        clock.sleep_until(clock.now() + 0.005)
    pytest.fail("it goes on telling the time")


def test_time_and_values_go_on_by_themselves(following: StreamReader) -> None:
    following.stream(requests.joint_position(LEFT))
    following.set(requests.joint_target_velocity(LEFT, 2.0))
    wait_for(lambda: following.time_s > 0.3)
    first = following.newest(requests.joint_position(LEFT))
    wait_for(lambda: following.newest(requests.joint_position(LEFT)).time_s > first.time_s)
    before = following.time_s
    second = following.newest(requests.joint_position(LEFT))
    assert second.value - first.value == pytest.approx(2.0 * (second.time_s - first.time_s), abs=1e-5)
    assert before <= second.time_s <= following.time_s


def test_what_is_streamed_can_be_asked_for_without_ending_its_stream(following: StreamReader) -> None:
    following.stream(requests.joint_position(LEFT))
    following.call(requests.joint_position(LEFT))
    following.call(requests.CLOCK)
    before = following.newest(requests.joint_position(LEFT)).time_s
    wait_for(lambda: following.newest(requests.joint_position(LEFT)).time_s > before)


def test_what_the_simulator_refuses_is_reported(following: StreamReader) -> None:
    with pytest.raises(RefusedError, match="find '/nope'"):
        following.call(requests.object_handle("/nope"))
    with pytest.raises(RefusedError, match="position of joint 99999"):
        following.stream(requests.joint_position(99999))

    def is_reported() -> bool:
        try:
            following.set(requests.joint_target_velocity(99999, 1.0))
        except RefusedError:
            return True
        return False

    wait_for(is_reported)


def test_a_server_that_is_gone_is_reported_by_everything(following: StreamReader, server: LegacyServer) -> None:
    server.service.hang_up()
    assert isinstance(error_of(following), ServerLostError)
    with pytest.raises(ServerLostError):
        following.set(requests.joint_target_velocity(LEFT, 1.0))
    with pytest.raises(ServerLostError):
        following.call(requests.object_handle("/rover"))


def test_a_server_that_hangs_is_reported_in_time(following: StreamReader, server: LegacyServer) -> None:
    hang = Hang()
    server.service.fail(hang)
    assert isinstance(error_of(following), ServerHangsError)
    hang.release()


def test_a_simulator_that_answers_and_does_nothing_is_reported(
    following: StreamReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
    assert f"has done nothing for {TIMEOUT_S} s" in str(error_of(following))


def test_stop_returns_when_it_has_stopped_and_start_when_it_runs_again(following: StreamReader) -> None:
    wait_for(lambda: following.time_s > 0.2)
    following.stop()
    assert not following.server.is_running
    following.start()
    assert following.time_s < 1.0


def test_a_simulation_that_is_stopped_has_no_time(following: StreamReader, simulator: Simulator) -> None:
    with simulator.lock:
        simulator.stop()
    assert isinstance(error_of(following), SimulationHaltedError)


def test_simulation_that_was_stopped_and_started_again_unseen_is_reported_and_not_waited_for(
    following: StreamReader, simulator: Simulator
) -> None:
    wait_for(lambda: following.time_s > 0.3)
    with simulator.lock:
        simulator.stop()
        simulator.start()
    assert "stopped" in str(error_of(following))
    assert "stopped" in str(error_of(following)), "whoever asks first need not be who waits"


def test_what_was_sent_last_is_done_before_it_hangs_up(server: LegacyServer, simulator: Simulator) -> None:
    with StreamReader.to("127.0.0.1", server.port) as following:
        following.set(requests.joint_target_velocity(LEFT, 3.0))
        following.set(requests.joint_target_velocity(LEFT, 0.0))
    assert simulator.graph[LEFT].target_velocity == 0.0  # type: ignore[attr-defined]


def test_the_service_of_a_scene_ends_with_its_simulation(server: LegacyServer, simulator: Simulator) -> None:
    with simulator.lock:
        simulator.start()
    service = server.start_temporary()
    with StreamReader.to("127.0.0.1", service.port, TIMEOUT_S) as following:
        with simulator.lock:
            simulator.stop()
        assert isinstance(error_of(following), (ServerLostError, SimulationHaltedError))

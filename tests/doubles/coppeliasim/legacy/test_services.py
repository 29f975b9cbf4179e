"""Tests of services on sockets: the order of replies, stepping, and faults."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress

import pytest

from tests.doubles.coppeliasim.legacy.codec import Code, Command, Mode, encode_packets, read_message
from tests.doubles.coppeliasim.legacy.comparison import PATIENCE_S, RawClient, floats, ints, name
from tests.doubles.coppeliasim.legacy.faults import CutReplies, DropConnection, Hang, SendGarbage
from tests.doubles.coppeliasim.legacy.recorded import later_scene
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State

LEFT, RIGHT = 182, 184
START, STOP = ints(0), ints(2)
SOON_S = 0.05


@pytest.fixture
def simulator() -> Simulator:
    return later_scene(180)


@pytest.fixture
def server(simulator: Simulator) -> Iterator[LegacyServer]:
    with LegacyServer(simulator) as server:
        yield server


def start_in_steps(client: RawClient) -> None:
    client.execute(Code.SYNCHRONOUS_ENABLE)
    client.execute(Code.START_PAUSE_STOP_SIMULATION, START)


def wait_for(simulator: Simulator, state: State) -> None:
    with simulator.lock:
        assert simulator.changed.wait_for(lambda: simulator.state is state, PATIENCE_S)


def test_result_comes_with_the_reply_to_the_next_message(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        header, commands = client.exchange(Command(Code.GET_OBJECT_HANDLE, Mode.BLOCKING, name("/rover")))
        assert (header.message, commands) == (-1, [])
        header, (reply,) = client.exchange()
        assert (header.message, reply.data) == (0, ints(181))


def test_long_message_has_packets_of_1300_bytes(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        for _ in range(50):
            client.execute(Code.GET_JOINT_POSITION, ints(99999))
        client.exchange(Command(Code.GET_LAST_ERRORS, Mode.BLOCKING))
        client.send()
        sizes: list[int] = []

        def receive(size: int) -> bytes:
            sizes.append(size)
            return client.line.recv(size)

        assert len(read_message(receive)) == sum(sizes[1::2])
        assert sizes[::2] == [6] * (len(sizes) // 2)
        assert sizes[1] == 1294
        assert len(sizes) > 2


def test_stream_repeats_until_it_is_discontinued(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        client.exchange(Command(Code.GET_JOINT_POSITION, Mode.STREAMING, ints(LEFT)))
        assert [len(client.exchange()[1]) for _ in range(3)] == [1, 1, 1]
        client.exchange(Command(Code.GET_JOINT_POSITION, Mode.DISCONTINUE, ints(LEFT)))
        assert [command.mode for command in client.exchange()[1]] == [Mode.DISCONTINUE]
        assert client.exchange()[1] == []


def test_stream_respects_its_delay(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        client.exchange(Command(Code.GET_JOINT_POSITION, Mode.STREAMING, ints(LEFT), delay_ms=60_000))
        assert [len(client.exchange()[1]) for _ in range(3)] == [1, 0, 0]


def test_newer_command_replaces_the_same_one_unless_both_are_kept(server: LegacyServer) -> None:
    command = Command(Code.SET_JOINT_TARGET_VELOCITY, Mode.ONESHOT, ints(LEFT), floats(1.0))
    keep = Command(Code.SET_JOINT_TARGET_VELOCITY, Mode.ONESHOT, ints(LEFT), floats(2.0), status=1)
    with RawClient(server.port) as client:
        client.exchange(command, command)
        assert len(client.exchange()[1]) == 1
        client.exchange(command, keep)
        assert len(client.exchange()[1]) == 2


def test_time_advances_by_itself_if_no_client_steps(server: LegacyServer, simulator: Simulator) -> None:
    with RawClient(server.port) as client:
        client.execute(Code.START_PAUSE_STOP_SIMULATION, START)
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.steps >= 3, PATIENCE_S)
        assert client.execute(Code.SYNCHRONOUS_NEXT).status == 1
        client.execute(Code.START_PAUSE_STOP_SIMULATION, STOP)
        wait_for(simulator, State.STOPPED)


def test_stepped_time_waits_for_triggers(server: LegacyServer, simulator: Simulator) -> None:
    with RawClient(server.port) as client:
        start_in_steps(client)
        time.sleep(SOON_S)
        assert client.execute(Code.GET_JOINT_POSITION, ints(LEFT)).sim_ms == 0
        client.execute(Code.SET_JOINT_TARGET_VELOCITY, ints(LEFT), floats(3.0))
        assert client.execute(Code.SYNCHRONOUS_NEXT).status == 0
        reply = client.execute(Code.GET_JOINT_POSITION, ints(LEFT))
        assert (reply.sim_ms, reply.data) == (50, floats(0.15))


def test_time_advances_after_stepping_ends(server: LegacyServer, simulator: Simulator) -> None:
    with RawClient(server.port) as client:
        start_in_steps(client)
        client.execute(Code.SYNCHRONOUS_DISABLE)
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.steps >= 1, PATIENCE_S)


def test_time_advances_after_a_stepping_client_ended(server: LegacyServer, simulator: Simulator) -> None:
    with RawClient(server.port) as client:
        start_in_steps(client)
    with simulator.lock:
        assert simulator.changed.wait_for(lambda: simulator.steps >= 1, PATIENCE_S)


def test_second_client_is_answered_after_the_first_has_left(server: LegacyServer) -> None:
    with RawClient(server.port) as first, RawClient(server.port) as second:
        first.exchange()
        second.send()
        second.line.settimeout(SOON_S)
        with pytest.raises(TimeoutError):
            second.line.recv(1)
        second.line.settimeout(PATIENCE_S)
        first.exchange(Command(Code.KILL_CONNECTION, Mode.ONESHOT, ints(0)))
        assert first.line.recv(1) == b""
        assert second.exchange()[0].message == -1


def test_only_a_temporary_service_ends_with_the_simulation(server: LegacyServer, simulator: Simulator) -> None:
    with RawClient(server.port) as client:
        start_in_steps(client)
        temporary = server.start_temporary()
        with RawClient(temporary.port) as other:
            assert other.execute(Code.GET_OBJECT_HANDLE, name("/rover")).data == ints(181)
            client.execute(Code.START_PAUSE_STOP_SIMULATION, STOP)
            wait_for(simulator, State.STOPPED)
            assert other.line.recv(1) == b""
        with pytest.raises(ConnectionRefusedError):
            RawClient(temporary.port)
        assert client.execute(Code.GET_OBJECT_HANDLE, name("/rover")).status == 0


def test_temporary_service_started_early_lasts_for_one_simulation(server: LegacyServer, simulator: Simulator) -> None:
    with RawClient(server.start_temporary().port) as client:
        start_in_steps(client)
        client.execute(Code.START_PAUSE_STOP_SIMULATION, STOP)
        wait_for(simulator, State.STOPPED)
        assert client.line.recv(1) == b""


def test_hanging_server_sends_nothing_until_released(server: LegacyServer) -> None:
    hanging = Hang()
    with RawClient(server.port) as client:
        server.service.fail(hanging, after=1)
        client.exchange()
        client.send()
        client.line.settimeout(SOON_S)
        with pytest.raises(TimeoutError):
            client.line.recv(1)
        client.line.settimeout(PATIENCE_S)
        hanging.release()
        assert client.line.recv(2) == b"\1\0"


def test_hanging_server_can_be_closed(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        server.service.fail(Hang())
        client.send()
        time.sleep(SOON_S)
        server.close()


def test_dropped_connection_sends_a_part_of_a_reply(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        server.service.fail(DropConnection(sent=7))
        client.send()
        assert len(client.line.recv(100)) + len(client.line.recv(100)) == 7
        assert client.line.recv(1) == b""
        server.service.fail(None)
    with RawClient(server.port) as client:
        assert client.exchange()[0].message == -1


def test_replies_are_cut_or_replaced(server: LegacyServer) -> None:
    with RawClient(server.port) as client:
        server.service.fail(CutReplies(sent=3))
        client.send()
        assert client.line.recv(100) == b"\1\0\x12"
        server.service.fail(SendGarbage(b"nonsense"))
        client.send()
        assert client.line.recv(100) == b"nonsense"


def test_restarted_server_has_the_same_port(server: LegacyServer) -> None:
    port = server.port
    with RawClient(port) as old:
        old.exchange()
        server.restart()
        assert old.line.recv(1) == b""
        with RawClient(port) as new:
            assert new.exchange()[0].message == -1
    assert server.port == port


@pytest.mark.parametrize(
    "said", [b"\1\0\4\0\0\0abcd", b"\0\1\4\0\0\0abcd", encode_packets(bytes(18)), encode_packets(bytes(17))]
)
def test_invalid_message_closes_the_connection(server: LegacyServer, said: bytes) -> None:
    with RawClient(server.port) as client:
        client.line.sendall(said)
        with suppress(ConnectionResetError):
            assert client.line.recv(1) == b""
    with RawClient(server.port) as client:
        assert client.exchange()[0].message == -1

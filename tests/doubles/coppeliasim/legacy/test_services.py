"""Services on true sockets: who is answered when, whose time it is, and how a server fails."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress

import pytest

from tests.doubles.coppeliasim.legacy.codec import Code, Command, Mode, packed_up, read_message
from tests.doubles.coppeliasim.legacy.comparison import PATIENCE_S, Talker, floats, ints, name
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


def start_in_steps(client: Talker) -> None:
    client.ask(Code.SYNCHRONOUS_ENABLE)
    client.ask(Code.START_PAUSE_STOP_SIMULATION, START)


def wait_for(simulator: Simulator, state: State) -> None:
    with simulator.lock:
        assert simulator.changed.wait_for(lambda: simulator.state is state, PATIENCE_S)


def test_a_reply_comes_with_the_answer_to_the_next_message(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        header, commands = client.say(Command(Code.GET_OBJECT_HANDLE, Mode.BLOCKING, name("/rover")))
        assert (header.message, commands) == (-1, [])
        header, (reply,) = client.say()
        assert (header.message, reply.data) == (0, ints(181))


def test_a_long_message_comes_in_packets_of_1300_bytes(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        for _ in range(50):
            client.ask(Code.GET_JOINT_POSITION, ints(99999))
        client.say(Command(Code.GET_LAST_ERRORS, Mode.BLOCKING))
        client.send()
        sizes: list[int] = []

        def receive(size: int) -> bytes:
            sizes.append(size)
            return client.line.recv(size)

        assert len(read_message(receive)) == sum(sizes[1::2])
        assert sizes[::2] == [6] * (len(sizes) // 2)
        assert sizes[1] == 1294
        assert len(sizes) > 2


def test_a_stream_comes_again_by_itself_and_no_more_once_it_is_discontinued(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        client.say(Command(Code.GET_JOINT_POSITION, Mode.STREAMING, ints(LEFT)))
        assert [len(client.say()[1]) for _ in range(3)] == [1, 1, 1]
        client.say(Command(Code.GET_JOINT_POSITION, Mode.DISCONTINUE, ints(LEFT)))
        assert [command.mode for command in client.say()[1]] == [Mode.DISCONTINUE]
        assert client.say()[1] == []


def test_a_stream_with_a_delay_comes_no_more_often(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        client.say(Command(Code.GET_JOINT_POSITION, Mode.STREAMING, ints(LEFT), delay_ms=60_000))
        assert [len(client.say()[1]) for _ in range(3)] == [1, 0, 0]


def test_a_newer_command_takes_the_place_of_the_same_one_unless_both_are_to_be_kept(server: LegacyServer) -> None:
    command = Command(Code.SET_JOINT_TARGET_VELOCITY, Mode.ONESHOT, ints(LEFT), floats(1.0))
    keep = Command(Code.SET_JOINT_TARGET_VELOCITY, Mode.ONESHOT, ints(LEFT), floats(2.0), status=1)
    with Talker(server.port) as client:
        client.say(command, command)
        assert len(client.say()[1]) == 1
        client.say(command, keep)
        assert len(client.say()[1]) == 2


def test_time_that_nobody_holds_passes_by_itself(server: LegacyServer, simulator: Simulator) -> None:
    with Talker(server.port) as client:
        client.ask(Code.START_PAUSE_STOP_SIMULATION, START)
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.steps >= 3, PATIENCE_S)
        assert client.ask(Code.SYNCHRONOUS_NEXT).status == 1
        client.ask(Code.START_PAUSE_STOP_SIMULATION, STOP)
        wait_for(simulator, State.STOPPED)


def test_time_that_is_held_stands_until_it_is_triggered(server: LegacyServer, simulator: Simulator) -> None:
    with Talker(server.port) as client:
        start_in_steps(client)
        time.sleep(SOON_S)
        assert client.ask(Code.GET_JOINT_POSITION, ints(LEFT)).sim_ms == 0
        client.ask(Code.SET_JOINT_TARGET_VELOCITY, ints(LEFT), floats(3.0))
        assert client.ask(Code.SYNCHRONOUS_NEXT).status == 0
        reply = client.ask(Code.GET_JOINT_POSITION, ints(LEFT))
        assert (reply.sim_ms, reply.data) == (50, floats(0.15))


def test_who_steps_no_longer_lets_time_pass(server: LegacyServer, simulator: Simulator) -> None:
    with Talker(server.port) as client:
        start_in_steps(client)
        client.ask(Code.SYNCHRONOUS_DISABLE)
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.steps >= 1, PATIENCE_S)


def test_who_dies_holds_time_no_longer(server: LegacyServer, simulator: Simulator) -> None:
    with Talker(server.port) as client:
        start_in_steps(client)
    with simulator.lock:
        assert simulator.changed.wait_for(lambda: simulator.steps >= 1, PATIENCE_S)


def test_a_second_client_is_answered_when_the_first_has_left(server: LegacyServer) -> None:
    with Talker(server.port) as first, Talker(server.port) as second:
        first.say()
        second.send()
        second.line.settimeout(SOON_S)
        with pytest.raises(TimeoutError):
            second.line.recv(1)
        second.line.settimeout(PATIENCE_S)
        first.say(Command(Code.KILL_CONNECTION, Mode.ONESHOT, ints(0)))
        assert first.line.recv(1) == b""
        assert second.say()[0].message == -1


def test_a_temporary_service_dies_with_the_stop_and_a_continuous_one_does_not(
    server: LegacyServer, simulator: Simulator
) -> None:
    with Talker(server.port) as client:
        start_in_steps(client)
        temporary = server.start_temporary()
        with Talker(temporary.port) as other:
            assert other.ask(Code.GET_OBJECT_HANDLE, name("/rover")).data == ints(181)
            client.ask(Code.START_PAUSE_STOP_SIMULATION, STOP)
            wait_for(simulator, State.STOPPED)
            assert other.line.recv(1) == b""
        with pytest.raises(ConnectionRefusedError):
            Talker(temporary.port)
        assert client.ask(Code.GET_OBJECT_HANDLE, name("/rover")).status == 0


def test_a_temporary_service_that_is_started_early_lives_through_one_run(
    server: LegacyServer, simulator: Simulator
) -> None:
    with Talker(server.start_temporary().port) as client:
        start_in_steps(client)
        client.ask(Code.START_PAUSE_STOP_SIMULATION, STOP)
        wait_for(simulator, State.STOPPED)
        assert client.line.recv(1) == b""


def test_a_server_that_hangs_sends_nothing_until_it_is_released(server: LegacyServer) -> None:
    hanging = Hang()
    with Talker(server.port) as client:
        server.service.fail(hanging, after=1)
        client.say()
        client.send()
        client.line.settimeout(SOON_S)
        with pytest.raises(TimeoutError):
            client.line.recv(1)
        client.line.settimeout(PATIENCE_S)
        hanging.release()
        assert client.line.recv(2) == b"\1\0"


def test_a_server_that_hangs_can_be_closed(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        server.service.fail(Hang())
        client.send()
        time.sleep(SOON_S)
        server.close()


def test_a_server_that_dies_sends_the_beginning_of_a_reply(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        server.service.fail(DropConnection(sent=7))
        client.send()
        assert len(client.line.recv(100)) + len(client.line.recv(100)) == 7
        assert client.line.recv(1) == b""
        server.service.fail(None)
    with Talker(server.port) as client:
        assert client.say()[0].message == -1


def test_replies_are_cut_or_replaced(server: LegacyServer) -> None:
    with Talker(server.port) as client:
        server.service.fail(CutReplies(sent=3))
        client.send()
        assert client.line.recv(100) == b"\1\0\x12"
        server.service.fail(SendGarbage(b"nonsense"))
        client.send()
        assert client.line.recv(100) == b"nonsense"


def test_a_restarted_server_is_on_the_same_port(server: LegacyServer) -> None:
    port = server.port
    with Talker(port) as old:
        old.say()
        server.restart()
        assert old.line.recv(1) == b""
        with Talker(port) as new:
            assert new.say()[0].message == -1
    assert server.port == port


@pytest.mark.parametrize("said", [b"\1\0\4\0\0\0abcd", b"\0\1\4\0\0\0abcd", packed_up(bytes(18)), packed_up(bytes(17))])
def test_who_says_what_is_no_message_is_hung_up_on(server: LegacyServer, said: bytes) -> None:
    with Talker(server.port) as client:
        client.line.sendall(said)
        with suppress(ConnectionResetError):
            assert client.line.recv(1) == b""
    with Talker(server.port) as client:
        assert client.say()[0].message == -1

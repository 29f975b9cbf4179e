"""A connection to a server: time steps, streamed values, refusals, and failures of the server."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.vrep.connection import Connection
from drivers.vrep.scene import StreamedScene
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Piece, encode_message
from drivers.vrep.wire.errors import (
    NoServerError,
    ProtocolError,
    RefusedError,
    RemoteApiError,
    ServerLostError,
    ServerTimeoutError,
    SimulationHaltedError,
)
from drivers.vrep.wire.message_socket import MessageSocket, encode_packets
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.legacy.faults import CutReplies, DropConnection, Fault, Hang, SendGarbage
from tests.doubles.coppeliasim.legacy.server import LegacyServer, Service
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.scenes import default_scene
from tests.texts import Raises

HOST = "127.0.0.1"
BODY, LEFT, RIGHT, CAMERA, UNKNOWN = 181, 182, 184, 190, 99999
PATIENCE_S = 10.0
SHORT_S = 0.1
"""The time limit of requests that must fail, in seconds."""

LONGER_S = 0.6
"""The time limit of requests that a server answers even on a busy machine, in seconds."""

WHOLE_REPLY = encode_packets(encode_message(-1, 0, []))


@pytest.fixture
def connection(server: LegacyServer) -> Iterator[Connection]:
    with Connection.open(HOST, server.port) as connection:
        yield connection


@pytest.fixture
def stepped(connection: Connection) -> Connection:
    connection.wait_for_triggers(wait=True)
    connection.start()
    return connection


@pytest.fixture
def streaming(connection: Connection) -> StreamedScene:
    scene = StreamedScene(connection)
    scene.start()
    return scene


def read_target(simulator: Simulator, handle: int) -> float:
    joint = simulator.graph[handle]
    assert isinstance(joint, Joint)
    return joint.target_velocity


def test_step_advances_one_time_step_and_reads_the_values_after_it(stepped: Connection, simulator: Simulator) -> None:
    reads = requests.joint_position(LEFT), requests.colour_image(CAMERA), requests.object_position(BODY)
    for count in range(1, 11):
        stepped.post(requests.joint_target_velocity(LEFT, 3.0))
        stepped.post(requests.joint_target_velocity(RIGHT, 3.0))
        angle, image, (x, _, _) = stepped.step(*reads)
        assert simulator.steps == count
        assert stepped.time_s == pytest.approx(count * 0.05)
        assert angle == pytest.approx(3.0 * 0.05 * count, abs=1e-6)
    assert x == pytest.approx(3.0 * 0.5 * 0.0325)
    assert (image.shape, image.flags.writeable) == ((12, 16, 3), False)
    grey = stepped.call(requests.grey_image(CAMERA))
    assert (grey == (image.astype(int).sum(axis=2) // 3)).all()
    assert stepped.step() == ()
    assert [stepped.call(requests.CLOCK) and stepped.time_s for _ in range(9)] == [pytest.approx(0.55)] * 9


def test_value_from_before_the_step_is_requested_again(stepped: Connection, monkeypatch: pytest.MonkeyPatch) -> None:
    read, fetched = requests.joint_position(LEFT), list[list[int]]()
    fetch_all = Connection._fetch_all

    def fetch_early(self: Connection, wanted: Any, *mode: int) -> list[Piece]:
        answers = fetch_all(self, wanted, *mode)
        if wanted[0] == read:
            fetched.append([each.time_ms for each in answers])
            if len(fetched) == 1:
                return [Piece(each.command, each.key, 0, 0, False, each.data) for each in answers]
        return answers

    monkeypatch.setattr(Connection, "_fetch_all", fetch_early)
    assert stepped.step(read) == (0.0,)
    assert fetched == [[50], [50]]


def test_later_command_replaces_an_earlier_one_and_the_last_is_done_before_disconnecting(
    server: LegacyServer, simulator: Simulator
) -> None:
    with Connection.open(HOST, server.port) as connection:
        connection.call(requests.joint_target_velocity(np.int64(LEFT), np.float32(2.5)))  # type: ignore[arg-type]
        assert read_target(simulator, LEFT) == 2.5
        for velocity in (5.0, 0.0):
            connection.post(requests.joint_target_velocity(LEFT, velocity))
    assert read_target(simulator, LEFT) == 0.0
    with Connection.open(HOST, server.port) as again:
        assert again.call(requests.object_handle("/rover")) == BODY


def test_refusal_is_raised_by_the_call_that_receives_it(stepped: Connection, raises: Raises) -> None:
    with raises(RefusedError, action=f"drive joint {UNKNOWN}"):
        stepped.call(requests.joint_target_velocity(UNKNOWN, 1.0))
    with raises(RefusedError, action=f"read the position of joint {UNKNOWN}"):
        stepped.step(requests.joint_position(LEFT), requests.joint_position(UNKNOWN))
    with raises(RefusedError, action=f"show a picture on vision sensor {CAMERA}"):
        stepped.call(requests.set_colour_image(CAMERA, bytes(3)))
    stepped.post(requests.joint_target_velocity(UNKNOWN, 1.0))
    with raises(RefusedError, action=f"drive joint {UNKNOWN}"):
        stepped.step()
    stepped.step(requests.joint_position(LEFT))


def test_wheel_is_stopped_although_a_command_was_refused(connection: Connection, simulator: Simulator) -> None:
    connection.call(requests.joint_target_velocity(LEFT, 3.0))
    refused = requests.set_colour_image(CAMERA, bytes(3))
    connection.post(refused)
    wait_for(lambda: connection._pump.newest(refused))
    connection.post(requests.joint_target_velocity(LEFT, 0.0))
    with pytest.raises(RefusedError):
        connection.call(requests.CLOCK)
    assert read_target(simulator, LEFT) == 0.0


def test_step_of_a_running_simulation_that_waits_for_no_trigger_is_an_error(
    connection: Connection, raises: Raises
) -> None:
    connection.start()
    with raises(SimulationHaltedError, "trigger-refused"):
        connection.step()


@pytest.mark.parametrize("halt, kind", [(Simulator.stop, "simulation-stopped"), (Simulator.pause, "simulation-paused")])
def test_step_after_the_user_has_halted_the_simulation_is_an_error(
    stepped: Connection, simulator: Simulator, halt: Callable[[Simulator], None], kind: str
) -> None:
    stepped.step()
    with simulator.lock:
        halt(simulator)
    assert await_error(stepped.step).kind == kind  # a pause begins after one more step


def test_stop_and_start_wait_for_the_state(stepped: Connection) -> None:
    stepped.step()
    stepped.stop()
    assert (stepped.server.is_running, stepped.time_s) == (False, 0.0)
    stepped.wait_for_triggers(wait=True)
    stepped.start()
    stepped.step()
    assert stepped.time_s == pytest.approx(0.05)


def test_calls_from_several_threads_get_their_own_answers(connection: Connection) -> None:
    names = {"/rover": BODY, "/rover/leftMotor": LEFT, "/rover/rightMotor": RIGHT, "/rover/camera": CAMERA}
    wrong: list[str] = []

    def ask(name: str) -> None:
        answers = (connection.call(requests.object_handle(name)) for _ in range(20))
        wrong.extend(name for answer in answers if answer != names[name])

    threads = [threading.Thread(target=ask, args=(name,)) for name in [*names, "/rover"]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def wait_for(condition: Callable[[], object]) -> None:
    clock = MonotonicClock()
    while not condition():
        assert clock.now() < PATIENCE_S
        clock.sleep_until(clock.now() + 0.005)


def await_error(read: Callable[[], object]) -> RemoteApiError:
    """Call a function until it raises an error, and return the error."""
    errors: list[RemoteApiError] = []

    def is_failed() -> bool:
        try:
            read()
        except RemoteApiError as error:
            errors.append(error)
        return bool(errors)

    wait_for(is_failed)
    return errors[0]


@pytest.mark.slow
def test_streamed_time_and_values_advance_by_themselves(streaming: StreamedScene, connection: Connection) -> None:
    joint = requests.joint_position(LEFT)
    connection.post(requests.joint_target_velocity(LEFT, 2.0))
    connection.read_newest(joint)
    wait_for(lambda: streaming.read_time() > 0.3)
    connection.call(joint)  # does not end the stream
    before, first = streaming.read_time(), connection.read_newest(joint)
    wait_for(lambda: connection.read_newest(joint).time_s > first.time_s)
    second = connection.read_newest(joint)
    assert second.value - first.value == pytest.approx(2.0 * (second.time_s - first.time_s), abs=1e-5)
    assert before <= second.time_s <= streaming.read_time()
    streaming.stop()
    streaming.start()
    assert streaming.read_time() < 1.0


def test_refusal_without_lockstep_is_an_error(streaming: StreamedScene, connection: Connection) -> None:
    with pytest.raises(RefusedError):
        connection.read_newest(requests.joint_position(UNKNOWN))
    connection.post(requests.joint_target_velocity(UNKNOWN, 1.0))
    assert isinstance(await_error(streaming.read_time), RefusedError)


def test_each_call_fails_after_the_connection_is_lost(streaming: StreamedScene, server: LegacyServer) -> None:
    server.service.disconnect()
    assert isinstance(await_error(streaming.read_time), ServerLostError)
    with pytest.raises(ServerLostError):
        streaming.set_joint_velocity(LEFT, 1.0)
    with pytest.raises(ServerLostError):
        streaming.find("/rover")


@pytest.mark.slow
def test_restart_of_the_simulation_is_an_error_in_each_read(streaming: StreamedScene, simulator: Simulator) -> None:
    wait_for(lambda: streaming.read_time() > 0.3)
    with simulator.lock:
        simulator.stop()
        simulator.start()
    assert [await_error(streaming.read_time).kind for _ in range(2)] == ["simulation-stopped"] * 2


def test_server_of_a_scene_ends_with_its_simulation(server: LegacyServer, simulator: Simulator) -> None:
    with simulator.lock:
        simulator.start()
    service = server.start_temporary()
    with Connection.open(HOST, service.port) as connection:
        scene = StreamedScene(connection)
        scene.start()
        with simulator.lock:
            simulator.stop()
        assert isinstance(await_error(scene.read_time), (ServerLostError, SimulationHaltedError))


@pytest.mark.slow
def test_simulator_that_does_nothing_times_out(
    server: LegacyServer, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    with Connection.open(HOST, server.port, 0.5) as connection:
        scene = StreamedScene(connection)
        scene.start()
        monkeypatch.setattr("tests.doubles.coppeliasim.legacy.client.Client.turn", lambda _: None)
        with raises(ServerTimeoutError, "simulator-busy", timeout_s=0.5):
            connection.call(requests.TIME_STEP)
        assert await_error(scene.read_time).kind == "simulator-busy"


@pytest.mark.slow
def test_time_that_stands_is_an_error_and_later_commands_are_executed(
    server: LegacyServer, simulator: Simulator, raises: Raises
) -> None:
    with Connection.open(HOST, server.port, 0.5) as connection:
        scene = StreamedScene(connection)
        scene.start()
        with simulator.lock:
            simulator.hold("another program")
        with raises(ServerTimeoutError, "simulation-stalled", timeout_s=0.5):
            scene.read_velocity(BODY)
        scene.set_joint_velocity(LEFT, 2.0)
    assert read_target(simulator, LEFT) == 2.0


@contextmanager
def serve_reply(reply: bytes) -> Iterator[int]:
    """Listen on a port, send one client these bytes, and close the connection."""

    def answer() -> None:
        with suppress(OSError):
            line, _ = listening.accept()
            with line:
                line.recv(1 << 16)
                line.sendall(reply)

    with socket.create_server((HOST, 0)) as listening:
        thread = threading.Thread(target=answer)
        thread.start()
        yield listening.getsockname()[1]
        with suppress(OSError):
            listening.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_address_without_a_server_is_an_error(unused_port: int, raises: Raises) -> None:
    with raises(NoServerError, hide=[unused_port], address=f"{HOST}:{unused_port}"):
        Connection.open(HOST, unused_port, connect_timeout_s=SHORT_S)
    with pytest.raises(NoServerError) as caught:  # the text has the system's own reason
        MessageSocket.open("robot.invalid", 19997, SHORT_S)
    assert caught.value.fields["address"] == "robot.invalid:19997"


def test_server_that_listens_later_is_found(server: LegacyServer) -> None:
    simulator, port = server._simulator, server.port
    server.close()
    services: list[Service] = []
    late = threading.Timer(2 * SHORT_S, lambda: services.append(Service(simulator, port)))
    late.start()
    try:
        with Connection.open(HOST, port) as connection:
            assert connection.call(requests.object_handle("/rover")) > 0
    finally:
        late.join()
        services.pop().close()


def test_second_program_on_a_port_is_refused(connection: Connection, server: LegacyServer, raises: Raises) -> None:
    with raises(ServerTimeoutError, "port-in-use", hide=[server.port]):
        Connection.open(HOST, server.port, SHORT_S)


@pytest.mark.parametrize(
    "fault, kind",
    [
        (DropConnection(), ServerLostError),
        (DropConnection(10), ServerLostError),
        (Hang(), ServerTimeoutError),
        (CutReplies(5), ServerTimeoutError),
        (SendGarbage(b"HTTP/1.1 400 Bad Request\r\n\r\n"), ProtocolError),
    ],
    ids=["killed", "killed in a reply", "hung", "cut", "another server"],
)
def test_failure_of_the_server_is_an_error_and_a_new_connection_works(
    fault: Fault, kind: type[RemoteApiError], server: LegacyServer
) -> None:
    with Connection.open(HOST, server.port, LONGER_S) as connection:
        connection.wait_for_triggers(wait=True)
        connection.start()
        server.service.fail(fault)
        clock = MonotonicClock()
        with pytest.raises(kind):
            connection.step()
        assert clock.now() < 2
        with pytest.raises(kind):
            connection.step()
    server.service.fail(None)
    server.restart()
    with Connection.open(HOST, server.port) as connection:
        connection.wait_for_triggers(wait=True)
        connection.step()


def test_slow_reply_times_out() -> None:
    stop = threading.Event()

    def trickle() -> None:
        line, _ = listening.accept()
        with line, suppress(OSError):
            line.sendall(bytes.fromhex("0100 ffff 0000"))
            while not stop.wait(SHORT_S / 10):
                line.sendall(b"?")

    with socket.create_server((HOST, 0)) as listening:
        thread = threading.Thread(target=trickle)
        thread.start()
        with pytest.raises(ServerTimeoutError):
            Connection.open(HOST, listening.getsockname()[1], SHORT_S)
        stop.set()
        thread.join()


def test_port_of_the_zeromq_remote_api_is_an_error(raises: Raises) -> None:
    with Double(default_scene()) as double, raises(ProtocolError):
        Connection.open(HOST, double.zmq_port, LONGER_S)


def test_bytes_after_the_end_of_a_reply_are_an_error(raises: Raises) -> None:
    with serve_reply(2 * WHOLE_REPLY) as port, raises(ProtocolError):
        MessageSocket.open(HOST, port, LONGER_S).exchange(0, [])


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.binary(max_size=80) | st.integers(0, len(WHOLE_REPLY) - 1).map(lambda size: WHOLE_REPLY[:size]))
def test_any_bytes_for_a_reply_are_a_named_error(reply: bytes) -> None:
    with serve_reply(reply) as port, pytest.raises(RemoteApiError) as caught:
        Connection.open(HOST, port, SHORT_S)
    assert caught.value.kind in {"invalid-reply", "port-in-use"}

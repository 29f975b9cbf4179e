"""Each failure of a server raises a specific error within the time limit."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.vrep.connection import LockstepConnection
from drivers.vrep.streaming import StreamReader
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import encode_message
from drivers.vrep.wire.errors import (
    NoServerError,
    ProtocolError,
    RemoteApiError,
    ServerLostError,
    ServerTimeoutError,
)
from drivers.vrep.wire.message_socket import MessageSocket, encode_packets
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.legacy.faults import CutReplies, DropConnection, Fault, Hang, SendGarbage
from tests.doubles.coppeliasim.legacy.server import LegacyServer, Service
from tests.doubles.coppeliasim.scenes import default_scene
from tests.texts import Raises

SHORT_S = 0.1
"""The time limit of requests that must fail, in seconds."""

LONGER_S = 0.6
"""The time limit of requests that a server answers even on a busy machine, in seconds."""

WHOLE_REPLY = encode_packets(encode_message(-1, 0, []))
OPENERS = [LockstepConnection.open, StreamReader.open]


@contextmanager
def serve_reply(reply: bytes) -> Iterator[int]:
    """Listen on a port, send one client these bytes, and close the connection."""

    def answer() -> None:
        with suppress(OSError):
            line, _ = listening.accept()
            with line:
                line.recv(1 << 16)
                line.sendall(reply)

    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=answer)
        thread.start()
        yield listening.getsockname()[1]
        with suppress(OSError):
            listening.shutdown(socket.SHUT_RDWR)
        thread.join()


@pytest.mark.parametrize("connect", OPENERS)
def test_address_without_a_server_is_an_error(connect: Callable[..., object], unused_port: int, raises: Raises) -> None:
    with raises(NoServerError, hide=[unused_port], address=f"127.0.0.1:{unused_port}"):
        connect("127.0.0.1", unused_port, connect_timeout_s=SHORT_S)


@pytest.mark.parametrize("connect", OPENERS)
def test_server_that_listens_later_is_found(connect: Callable[..., Any], server: LegacyServer) -> None:
    simulator, port = server._simulator, server.port
    server.close()
    services: list[Service] = []
    late = threading.Timer(2 * SHORT_S, lambda: services.append(Service(simulator, port)))
    late.start()
    try:
        with connect("127.0.0.1", port) as connection:
            assert connection.call(requests.object_handle("/rover")) > 0
    finally:
        late.join()
        services.pop().close()


def test_unknown_host_is_an_error() -> None:
    with pytest.raises(NoServerError) as caught:  # the text has the system's own reason
        MessageSocket.open("robot.invalid", 19997)
    assert caught.value.fields["address"] == "robot.invalid:19997"


@pytest.mark.parametrize("connect", OPENERS)
def test_second_program_on_a_port_is_refused(
    connect: Callable[..., object], server: LegacyServer, raises: Raises
) -> None:
    with (
        LockstepConnection.open("127.0.0.1", server.port),
        raises(ServerTimeoutError, "port-in-use", hide=[server.port]),
    ):
        connect("127.0.0.1", server.port, SHORT_S)


def test_connection_closed_before_the_first_reply_means_a_used_port(raises: Raises) -> None:
    with serve_reply(b"") as port, raises(ServerLostError, "port-in-use", hide=[port]):
        LockstepConnection.open("127.0.0.1", port, connect_timeout_s=0.0)


@pytest.mark.parametrize("kind", [LockstepConnection, StreamReader])
def test_server_that_closes_the_first_connection_is_tried_again(
    kind: type[LockstepConnection | StreamReader], server: LegacyServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    exchange = MessageSocket.exchange
    closed: list[MessageSocket] = []

    def close_first(link: MessageSocket, *message: Any) -> Any:
        if not closed:
            closed.append(link)
            link.close()
            raise ServerLostError("it hung up")
        return exchange(link, *message)

    monkeypatch.setattr(MessageSocket, "exchange", close_first)
    with kind.open("127.0.0.1", server.port, LONGER_S) as connected:
        assert not connected.server.is_running
    assert closed


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
def test_failure_in_a_step_is_an_error_and_a_new_connection_works(
    fault: Fault, kind: type[RemoteApiError], server: LegacyServer
) -> None:
    with LockstepConnection.open("127.0.0.1", server.port, LONGER_S) as connection:
        connection.wait_for_triggers(wait=True)
        connection.start()
        server.service.fail(fault)
        clock = MonotonicClock()
        with pytest.raises(kind):
            connection.step()
        assert clock.now() < 2
        with pytest.raises(RemoteApiError):
            connection.step()
    server.service.fail(None)
    server.restart()
    with LockstepConnection.open("127.0.0.1", server.port) as connection:
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

    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=trickle)
        thread.start()
        with pytest.raises(ServerTimeoutError):
            LockstepConnection.open("127.0.0.1", listening.getsockname()[1], SHORT_S)
        stop.set()
        thread.join()


def test_port_of_the_zeromq_remote_api_is_an_error(raises: Raises) -> None:
    with Double(default_scene()) as double, raises(ProtocolError):
        LockstepConnection.open("127.0.0.1", double.zmq_port, LONGER_S)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.binary(max_size=80) | st.integers(0, len(WHOLE_REPLY) - 1).map(lambda size: WHOLE_REPLY[:size]))
def test_any_bytes_for_a_reply_are_a_named_error(reply: bytes) -> None:
    with serve_reply(reply) as port, pytest.raises(RemoteApiError) as caught:
        LockstepConnection.open("127.0.0.1", port, SHORT_S)
    assert caught.value.kind in {"invalid-reply", "port-in-use"}

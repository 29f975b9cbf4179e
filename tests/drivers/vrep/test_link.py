"""What can go wrong with a server is a named error within the time-out, never a hang."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.vrep.connection import Connection
from drivers.vrep.streaming import StreamReader
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import encode_message, encode_packets
from drivers.vrep.wire.errors import (
    GarbledReplyError,
    NobodyListensError,
    RemoteApiError,
    ServerHangsError,
    ServerLostError,
)
from drivers.vrep.wire.link import Link
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.legacy.faults import CutReplies, DropConnection, Fault, Hang, SendGarbage
from tests.doubles.coppeliasim.legacy.server import LegacyServer, Service
from tests.doubles.coppeliasim.scenes import default_scene

SHORT_S = 0.1
"""Where nothing good comes within it anyway."""

LONGER_S = 0.6
"""Where a server is to answer first, on a machine that has other things to do."""

WHOLE_REPLY = encode_packets(encode_message(-1, 0, []))
ENDS = [Connection.to, StreamReader.to]


@contextmanager
def answering(reply: bytes) -> Iterator[int]:
    """Listen on a port, and send every client these bytes whatever it says, and hang up."""

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


@pytest.mark.parametrize("connect", ENDS)
def test_where_nobody_listens_it_says_what_to_start(connect: Callable[..., object], unused_port: int) -> None:
    with pytest.raises(NobodyListensError, match=rf":{unused_port} .*Start the simulator.*simRemoteApi.start"):
        connect("127.0.0.1", unused_port, patience_s=SHORT_S)


@pytest.mark.parametrize("connect", ENDS)
def test_a_server_that_listens_a_little_later_is_found(connect: Callable[..., Any], server: LegacyServer) -> None:
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


def test_a_name_that_no_machine_has_is_reported_as_well() -> None:
    with pytest.raises(NobodyListensError, match=r"robot\.invalid"):
        Link.to("robot.invalid", 19997)


@pytest.mark.parametrize("connect", ENDS)
def test_a_second_program_on_a_port_is_reported_the_first(connect: Callable[..., object], server: LegacyServer) -> None:
    with (
        Connection.to("127.0.0.1", server.port),
        pytest.raises(ServerHangsError, match="one program at a time: end the other one"),
    ):
        connect("127.0.0.1", server.port, SHORT_S)


def test_one_that_the_server_hangs_up_on_at_once_is_reported_the_first_as_well() -> None:
    with answering(b"") as port, pytest.raises(ServerLostError, match="one program at a time: end the other one"):
        Connection.to("127.0.0.1", port, patience_s=0.0)


@pytest.mark.parametrize("kind", [Connection, StreamReader])
def test_server_that_hangs_up_once_after_another_program_has_left_is_tried_again(
    kind: type[Connection | StreamReader], server: LegacyServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    exchange = Link.exchange
    hung_up_on: list[Link] = []

    def hang_up_first(link: Link, *said: Any) -> Any:
        if not hung_up_on:
            hung_up_on.append(link)
            link.close()
            raise ServerLostError("it hung up")
        return exchange(link, *said)

    monkeypatch.setattr(Link, "exchange", hang_up_first)
    with kind.to("127.0.0.1", server.port, LONGER_S) as connected:
        assert not connected.server.is_running
    assert hung_up_on


@pytest.mark.parametrize(
    "fault, kind",
    [
        (DropConnection(), ServerLostError),
        (DropConnection(10), ServerLostError),
        (Hang(), ServerHangsError),
        (CutReplies(5), ServerHangsError),
        (SendGarbage(b"HTTP/1.1 400 Bad Request\r\n\r\n"), GarbledReplyError),
    ],
    ids=["killed", "killed in a reply", "hung", "cut", "another server"],
)
def test_each_failure_in_a_step_is_a_named_error_and_a_new_connection_works(
    fault: Fault, kind: type[RemoteApiError], server: LegacyServer
) -> None:
    with Connection.to("127.0.0.1", server.port, LONGER_S) as connection:
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
    with Connection.to("127.0.0.1", server.port) as connection:
        connection.wait_for_triggers(wait=True)
        connection.step()


def test_a_reply_that_trickles_in_does_not_outlast_the_time_out() -> None:
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
        with pytest.raises(ServerHangsError):
            Connection.to("127.0.0.1", listening.getsockname()[1], SHORT_S)
        stop.set()
        thread.join()


def test_port_of_the_zeromq_remote_api_is_reported_with_its_backend() -> None:
    with Double(default_scene()) as double, pytest.raises(GarbledReplyError, match="which is --backend coppeliasim"):
        Connection.to("127.0.0.1", double.zmq_port, LONGER_S)


@settings(max_examples=40, deadline=None)
@given(st.binary(max_size=80) | st.integers(0, len(WHOLE_REPLY) - 1).map(lambda size: WHOLE_REPLY[:size]))
def test_any_bytes_for_a_reply_are_a_named_error(reply: bytes) -> None:
    with answering(reply) as port, pytest.raises(BackendError, match=r"no reply|hangs up|says nothing"):
        Connection.to("127.0.0.1", port, SHORT_S)

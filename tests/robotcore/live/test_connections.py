"""The limits of the connections to the live page: they keep the e-stop free."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from typing import Any
from urllib.parse import urlsplit

import pytest
from uvicorn.protocols.http.h11_impl import H11Protocol

from robotcore.errors import EmergencyStopError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.live.address import Address
from robotcore.live.connections import CHUNK_BYTES, MAX_CONNECTIONS, MAX_RATE_HZ, REQUEST_S, LimitedHttp, make_room
from robotcore.live.server import HELLO_S, PING_S
from tests.robotcore.live.client import TIMEOUT_S, Client
from tests.robotcore.live.live_run import LiveRun, StartRun

pytestmark = pytest.mark.slow

EVERYWHERE = "0.0.0.0"  # noqa: S104  pages for other machines are tested too

SOON_S = 10.0
"""The longest wait for a busy machine, in seconds."""

PING = b"\x89\x80" + b"\x00" * 4
TEXT_BEGIN = b"\x01\x80" + b"\x00" * 4
HELLO = b"\x81\x90" + b"\x00" * 4 + b'{"type":"hello"}'
UNFINISHED_TEXT = b"\x01\x81" + b"\x00" * 4 + b"{"
CONTINUATION = b"\x00\x80" + b"\x00" * 4


class Wires:
    """Plain connections to the page of a run."""

    def __init__(self, run: LiveRun, stack: ExitStack) -> None:
        self.where = urlsplit(run.view.link)
        self._stack = stack

    def connect(self, data: bytes = b"") -> socket.socket:
        wire = socket.create_connection((str(self.where.hostname), int(self.where.port or 0)), timeout=TIMEOUT_S)
        wire.sendall(data)
        return self._stack.enter_context(wire)

    def build_request(self, line: str, *headers: str) -> bytes:
        return "\r\n".join((f"{line} HTTP/1.1", f"Host: {self.where.netloc}", *headers, "", "")).encode()

    def upgrade(self) -> socket.socket:
        """Return a WebSocket that has sent no token."""
        key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA=="
        version, origin = "Sec-WebSocket-Version: 13", f"Origin: http://{self.where.netloc}"
        headers = ("Connection: Upgrade", "Upgrade: websocket", key, version, origin)
        wire = self.connect(self.build_request("GET /live", *headers))
        assert wire.recv(1000).startswith(b"HTTP/1.1 101 ")
        return wire

    def press_estop(self) -> bytes:
        request = self.build_request("POST /estop", "X-Robotcore: estop", "Content-Length: 0")
        return self.connect(request).recv(100).partition(b"\r\n")[0]


def is_closed(wire: socket.socket, seconds: float = SOON_S) -> bool:
    """Return whether the server closes a connection within a time. What it sends before is skipped."""
    clock = MonotonicClock()
    try:
        while clock.now() < seconds:
            wire.settimeout(max(0.001, seconds - clock.now()))
            if not wire.recv(100_000):
                return True
    except TimeoutError:
        return False
    except OSError:
        return True
    return False


@pytest.fixture
def run(start_run: StartRun) -> LiveRun:
    return start_run()


@pytest.fixture
def wires(run: LiveRun) -> Iterator[Wires]:
    with ExitStack() as stack:
        yield Wires(run, stack)


@pytest.mark.parametrize("frame", [PING, CONTINUATION], ids=["ping", "continuation"])
def test_a_socket_whose_first_frame_is_no_text_is_closed(wires: Wires, frame: bytes) -> None:
    wire = wires.upgrade()
    wire.sendall(frame)
    assert is_closed(wire)


@pytest.mark.parametrize("frames", [(PING, PING), (TEXT_BEGIN, CONTINUATION)], ids=["pings", "continuations"])
def test_a_flood_of_frames_that_are_no_messages_ends_its_sender(wires: Wires, frames: tuple[bytes, bytes]) -> None:
    first, next_ones = frames
    wire = wires.upgrade()
    wire.sendall(HELLO + first + next_ones * 50)
    assert not is_closed(wire, 0.5)
    with suppress(OSError):
        wire.sendall(next_ones * 2 * int(MAX_RATE_HZ))
    assert is_closed(wire)


def test_sockets_that_flood_pings_do_not_delay_the_estop(run: LiveRun, wires: Wires) -> None:
    flood = [wires.upgrade() for _ in range(30)]
    for wire in flood:
        wire.setblocking(False)
        with suppress(OSError):
            wire.send(PING * 40_000)
    clock = MonotonicClock()
    assert wires.press_estop() == b"HTTP/1.1 204 No Content"
    assert clock.now() < 3.0
    assert isinstance(run.wait().error, EmergencyStopError)


@pytest.mark.parametrize("line", ["GET /page/icon.svg", "POST /estop"])
def test_a_connection_ends_with_its_first_answer(wires: Wires, line: str) -> None:
    wire = wires.connect(wires.build_request(line, "Content-Length: 1000"))
    assert is_closed(wire)


def test_bytes_after_a_request_are_not_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    parsed: list[bytes] = []

    def parse(http: Any, data: bytes) -> None:
        parsed.append(data)
        http.cycle = "the answer to the request"

    monkeypatch.setattr(H11Protocol, "data_received", parse)
    http: Any = LimitedHttp.__new__(LimitedHttp)
    http.cycle, http.transport = None, Opened("192.0.2.1", 0.0)
    http.transport.get_protocol = lambda: http
    http.data_received(b"a" * CHUNK_BYTES + b"b")
    http.data_received(b"c")
    assert parsed == [b"a" * CHUNK_BYTES]


def test_a_request_that_never_ends_is_closed(wires: Wires) -> None:
    wire = wires.connect(b"GET / HTTP/1.1\r\n")
    assert not is_closed(wire, REQUEST_S - 2.0)
    wire.sendall(b"X: y\r\n")
    assert is_closed(wire, 2.0 + SOON_S)


def test_a_viewer_who_answers_no_ping_is_disconnected(run: LiveRun, wires: Wires) -> None:
    other = Client(run)
    other.receive("tick")
    wires.upgrade().sendall(HELLO)
    while other.receive("viewers")["count"] != 2:
        pass
    clock = MonotonicClock()
    while other.receive("viewers")["count"] != 1:
        pass
    assert clock.now() < 2 * PING_S + SOON_S
    other.close()


def test_sockets_without_the_token_block_no_estop(start_run: StartRun) -> None:
    run = start_run(Address(EVERYWHERE))
    with ExitStack() as stack:
        wires = Wires(run, stack)
        sockets = [wires.upgrade() for _ in range(MAX_CONNECTIONS)]
        for each in sockets:
            each.sendall(UNFINISHED_TEXT)
        assert wires.press_estop() == b"HTTP/1.1 204 No Content"
        assert isinstance(run.wait().error, EmergencyStopError)


def test_a_viewer_keeps_its_socket_while_others_come(run: LiveRun, wires: Wires) -> None:
    before = Client(run)
    before.receive("run")
    for _ in range(MAX_CONNECTIONS + 20):
        wires.upgrade().sendall(UNFINISHED_TEXT)
    assert before.receive("tick")
    before.close()


def test_a_socket_that_sends_no_token_is_closed(wires: Wires) -> None:
    wire = wires.upgrade()
    assert not is_closed(wire, HELLO_S / 2)
    assert is_closed(wire)


class Opened:
    """A connection from an address. It notes whether it was closed."""

    def __init__(self, address: str, started: float, *, is_viewer: bool = False) -> None:
        self.client, self.started, self.is_viewer = (address, 1), started, is_viewer
        self.transport, self.is_ended = self, False

    def is_closing(self) -> bool:
        return self.is_ended

    def abort(self) -> None:
        self.is_ended = True


def test_the_oldest_connection_of_the_address_with_the_most_makes_room() -> None:
    lone = Opened("192.0.2.1", 0.0)
    viewers = [Opened("192.0.2.3", 0.1, is_viewer=True) for _ in range(MAX_CONNECTIONS // 2)]
    many = [Opened("192.0.2.2", 1.0 + number) for number in range(MAX_CONNECTIONS // 2 - 1)]
    make_room([lone, *viewers, *many])
    assert not any(each.is_ended for each in [lone, *viewers, *many])
    make_room([lone, *viewers, *many, newest := Opened("192.0.2.2", 500.0)])
    assert [each for each in [lone, *viewers, *many, newest] if each.is_ended] == many[:1]


def test_connections_that_do_nothing_keep_neither_the_estop_nor_a_viewer_out(run: LiveRun, wires: Wires) -> None:
    before = Client(run)
    before.receive("run")
    silent = [wires.connect(b"GET / HTTP/1.1\r\nX: ") for _ in range(MAX_CONNECTIONS + 20)]
    assert is_closed(silent[0])
    assert not is_closed(silent[-1], 0.2)
    after = Client(run)
    assert after.receive("tick")
    assert before.receive("tick")
    assert wires.press_estop() == b"HTTP/1.1 204 No Content"
    assert isinstance(run.wait().error, EmergencyStopError)
    before.close()
    after.close()

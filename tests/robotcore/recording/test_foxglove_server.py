"""The server for Foxglove, with a real client of its protocol.

The protocol: https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from importlib.resources import files
from threading import Event, Thread
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

import robotcore
from robotcore import RunRequest, run
from robotcore.errors import UsageError
from robotcore.recording.codec import decode_compressed_image
from robotcore.recording.foxglove_server import FoxgloveServer
from robotcore.recording.writer import RecordingWriter
from robotcore.runtime.result import RunResult
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.conftest import cli as cli  # noqa: PLC0414  a fixture
from tests.robotcore.live.live_run import Circles
from tests.robotcore.recording.test_foxglove_channels import SCHEMAS
from tests.robotcore.runs import Watcher
from tests.texts import Raises

pytestmark = pytest.mark.slow

TIMEOUT_S = 10.0
SUBSCRIBING_S = 0.2
"""foxglove-sdk announces a new channel shortly before it accepts subscriptions."""

MESSAGE_DATA = struct.Struct("<BIQ")
"""The head of a message: opcode, number of the subscription, time in nanoseconds."""


class Client:
    """A client that subscribes to topics, each under its place in the list of topics."""

    def __init__(self, server: FoxgloveServer) -> None:
        self._stack = ExitStack()
        connection = connect(server.link, subprotocols=[Subprotocol("foxglove.sdk.v1")], close_timeout=0.5)
        self.socket: ClientConnection = self._stack.enter_context(connection)
        self.channels: dict[str, dict[str, Any]] = {}
        self.topics: list[str] = []

    def close(self) -> None:
        self._stack.close()

    def wait_for_channels(self, *topics: str) -> None:
        while not {*topics} <= self.channels.keys():
            data = self.socket.recv(TIMEOUT_S)
            if isinstance(data, str) and (message := json.loads(data))["op"] == "advertise":
                self.channels.update({each["topic"]: each for each in message["channels"]})

    def subscribe(self, *topics: str) -> None:
        self.wait_for_channels(*topics)
        Event().wait(SUBSCRIBING_S)
        self.topics = [*topics]
        wanted = [{"id": at, "channelId": self.channels[topic]["id"]} for at, topic in enumerate(topics)]
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))

    def receive(self) -> tuple[str, int, bytes]:
        """Return the topic, the time in nanoseconds and the content of the next message."""
        while True:
            data = self.socket.recv(TIMEOUT_S)
            if isinstance(data, bytes) and data[0] == 1:
                _, subscription, time = MESSAGE_DATA.unpack_from(data)
                return self.topics[subscription], time, data[MESSAGE_DATA.size :]


class ServedRun:
    """A run in a thread. Its server has the channels of the run before the constructor returns."""

    def __init__(self, server: FoxgloveServer, **request: Any) -> None:
        self._server, self._watcher = server, Watcher()
        self.result: RunResult | None = None
        fields = {"app": Circles, "world": "open", "realtime": True, "timeout_s": 60.0, **request}
        self._thread = Thread(target=self._run, args=(RunRequest(**fields),))
        self._thread.start()

    def wait(self) -> RunResult:
        self._thread.join(30.0)
        assert self.result
        return self.result

    def stop(self) -> None:
        if self._thread.is_alive():
            self._watcher.calls[0][1].emergency.press("the test has ended")
        self.wait()

    def _run(self, request: RunRequest) -> None:
        self.result = run(request, [self._watcher, self._server], [self._server.layer])


Serve = Callable[..., ServedRun]
Connect = Callable[[], Client]


@pytest.fixture
def server() -> Iterator[FoxgloveServer]:
    server = FoxgloveServer(0)
    yield server
    server.close()


@pytest.fixture
def serve(server: FoxgloveServer) -> Iterator[Serve]:
    """Start runs with the server. The end of the test ends them."""
    runs: list[ServedRun] = []

    def start(**request: Any) -> ServedRun:
        runs.append(ServedRun(server, **request))
        return runs[-1]

    yield start
    for each in runs:
        each.stop()


@pytest.fixture
def connect_client(server: FoxgloveServer) -> Iterator[Connect]:
    """Connect clients to the server. The end of the test closes them."""
    with ExitStack() as stack:
        yield lambda: stack.enter_context(closing(Client(server)))


def test_a_client_gets_the_channels_of_a_recording_with_their_schemas(serve: Serve, connect_client: Connect) -> None:
    serve()
    client = connect_client()
    assert client.socket.subprotocol == "foxglove.sdk.v1"
    wanted = {topic: schema for topic, schema in SCHEMAS.items() if topic != "/result"}
    live = {**wanted, "/eye": "foxglove.CompressedImage"}
    client.wait_for_channels(*live)
    assert {topic: client.channels[topic]["schemaName"] for topic in live} == live


def test_a_picture_and_a_tick_arrive(serve: Serve, connect_client: Connect) -> None:
    serve()
    client = connect_client()
    client.subscribe("/eye", "/ticks", "/log/gap")
    seen: dict[str, Any] = {}
    while len(seen) < 3:
        topic, time, content = client.receive()
        seen[topic] = time, content
    assert decode_compressed_image(seen["/eye"][1]).shape == (240, 320, 3)
    time, tick = seen["/ticks"][0], json.loads(seen["/ticks"][1])
    assert tick["time"] == pytest.approx(time / 1e9)
    assert tick["sent"]["right"] > tick["sent"]["left"] > 0
    assert json.loads(seen["/log/gap"][1])["unit"] == "m"


def test_a_client_that_comes_later_gets_the_run_the_mounts_and_the_calibration(
    serve: Serve, connect_client: Connect
) -> None:
    serve()
    first = connect_client()
    first.subscribe("/ticks")
    for _ in range(5):
        first.receive()
    second = connect_client()
    once = {"/run", "/tf_static", "/eye/calibration"}
    second.subscribe(*once)
    seen: dict[str, int] = {}
    while seen.keys() != once:
        topic, time, _ = second.receive()
        seen[topic] = time
    assert all(seen.values()), "the messages have the present time of the run"


def test_a_client_that_does_not_read_does_not_slow_the_run(serve: Serve, connect_client: Connect) -> None:
    served = serve(timeout_s=3.0)
    client = connect_client()
    client.subscribe("/eye", "/ticks", "/screen")
    result = served.wait()
    assert result.sim_time_s == pytest.approx(3.0)
    assert result.wall_time_s < 4.5


def test_the_server_does_not_change_the_run(server: FoxgloveServer) -> None:
    request = RunRequest("green-search", seed=7, timeout_s=5.0)
    assert run(request, [server], [server.layer]).trace_sha256 == run(request).trace_sha256


def test_a_failure_to_send_ends_the_server_and_not_the_run(
    server: FoxgloveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ValueError("no such message")

    monkeypatch.setattr(RecordingWriter, "write", fail)
    result = run(RunRequest("avoid-obstacles", timeout_s=2.0), [server], [server.layer])
    assert result.ticks == 41
    assert server.failure == "ValueError: no such message"


def test_a_port_that_is_taken_is_wrong_usage(server: FoxgloveServer, raises: Raises) -> None:
    port = int(server.link.rpartition(":")[2])
    with raises(UsageError, "cannot-listen", hide=[port], port=port):
        FoxgloveServer(port)


def test_the_command_prints_the_address_and_the_layout(cli: Cli) -> None:
    answer = cli("run", "avoid-obstacles", "--set", "duration_s=0.3", "--foxglove", "0", "--json")
    link, layout = answer.err.splitlines()
    assert link.startswith("The run in Foxglove: ws://127.0.0.1:")
    assert layout == f"The layout for Foxglove: {files('robotcore.recording') / 'foxglove-layout.json'}"
    assert answer.status == 0


def test_an_open_robot_prints_the_address(capsys: pytest.CaptureFixture[str]) -> None:
    with robotcore.open("rover", world="open", foxglove=0) as robot:
        assert capsys.readouterr().out.startswith("The run in Foxglove: ws://127.0.0.1:")
        robot.wait(0.1)


def test_the_layout_names_channels_that_exist() -> None:
    layout = json.loads((files("robotcore.recording") / "foxglove-layout.json").read_text())
    panels = layout["configById"]
    topics = {"/" + part.split("/", 1)[1].split(".")[0] for part in _list_texts(panels) if part.startswith("/")}
    assert topics <= SCHEMAS.keys()
    assert len(topics) > 4
    assert {*_list_texts(layout["layout"])} - {"row", "column"} == panels.keys()


def _list_texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for key, each in value.items():
            yield from [key] if key.startswith("/") else []
            yield from _list_texts(each)
    elif isinstance(value, list):
        for each in value:
            yield from _list_texts(each)

"""The server of the live page: what it sends, whom it refuses, and that no client harms the run."""

from __future__ import annotations

import http.client
import json
import os
import random
import socket
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

import cv2
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus

from robotcore.errors import EmergencyStopError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.live.address import Address
from robotcore.live.hub import MAX_VIEWERS
from robotcore.live.messages import Message
from robotcore.live.server import FLOOD, FULL, WRONG_TOKEN
from robotcore.live.snapshot import SnapshotBuilder
from tests.robotcore.live.client import Client
from tests.robotcore.live.hostile_messages import HOSTILE
from tests.robotcore.live.live_run import LiveRun, StartRun

pytestmark = pytest.mark.slow

EVERYWHERE = "0.0.0.0"  # noqa: S104  pages for other machines are tested too


@pytest.fixture
def run(start_run: StartRun) -> LiveRun:
    return start_run()


Enter = Callable[..., Client]
"""The type of the fixture `enter`: its arguments are those of `Client`, without the run."""


@pytest.fixture
def enter(run: LiveRun) -> Iterator[Enter]:
    """Connect clients to the run. The end of the test closes them."""
    clients: list[Client] = []

    def connect(*arguments: str, **options: str) -> Client:
        clients.append(Client(run, *arguments, **options))
        return clients[-1]

    yield connect
    for each in clients:
        each.close()


@pytest.fixture
def public_run(start_run: StartRun) -> LiveRun:
    """Start a run whose page other machines can reach."""
    return start_run(Address(EVERYWHERE))


def request(run: LiveRun, method: str, path: str, **headers: str) -> http.client.HTTPResponse:
    """Return the answer to a request. A header's name has ``_`` in place of ``-``."""
    connection = http.client.HTTPConnection(urlsplit(run.view.link).netloc, timeout=10)
    connection.request(method, path, headers={name.replace("_", "-"): value for name, value in headers.items()})
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer


def close_code(client: Client) -> int:
    """Return the code with which the server closes a client's socket."""
    with pytest.raises(ConnectionClosed) as closed:
        client.receive("nothing")
    return closed.value.rcvd.code if closed.value.rcvd else 0


def ticks_go_on(run: LiveRun) -> bool:
    clock, before = MonotonicClock(), len(run.watcher.calls)
    clock.sleep_until(0.5)
    return len(run.watcher.calls) >= before + 4


def test_a_viewer_gets_the_run_the_ticks_and_the_pictures(run: LiveRun, enter: Enter) -> None:
    client = enter()
    about = client.receive("run")
    assert (about["app"], about["backend"], about["robot"], about["world"]) == ("Circles", "kinematic", "rover", "open")
    assert {each["name"] for each in about["devices"]} == {*run.context.robot.devices}
    tick = later = client.receive("tick")
    while later["tick"] == tick["tick"]:  # a new viewer can get the present tick twice
        later = client.receive("tick")
    assert later["tick"] > tick["tick"]
    assert later["truth"] != tick["truth"]
    assert later["sent"][1] > later["sent"][0] > 0
    assert later["measured"] == pytest.approx(later["sent"], rel=0.5)
    assert later["devices"]["nose"]["rays"]["distances"]
    picture = cv2.imdecode(np.frombuffer(client.receive_picture("eye"), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (240, 320, 3)


def test_a_late_viewer_gets_the_path_and_the_velocities_of_the_wheels_so_far(enter: Enter) -> None:
    first = enter()
    begin = first.receive("tick")["time"]
    while first.receive("tick")["time"] < begin + 1.0:
        pass
    second = enter()
    history = second.receive("history")
    path, wheels = history["path"], history["wheels"]
    assert len(path) > 3
    assert path[0][2] == "turning"
    assert wheels[0]["time"] <= begin
    assert wheels[-1]["time"] > begin + 0.9
    assert wheels[-1]["sent"][1] > wheels[-1]["sent"][0] > 0


def test_a_viewer_gets_the_map_of_the_app(start_run: StartRun) -> None:
    run = start_run(app="green-search", seed=7, world=None)
    client = Client(run)
    drawing = cv2.imdecode(np.frombuffer(client.receive_picture("@map"), np.uint8), cv2.IMREAD_COLOR)
    assert drawing is not None
    assert len(np.unique(drawing)) > 1
    client.close()


def test_the_number_of_viewers_is_known_to_each(enter: Enter) -> None:
    first, second = enter(), enter()
    while first.receive("viewers")["count"] != 2:
        pass
    second.close()
    assert first.receive("viewers")["count"] == 1


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://localhost"])
def test_a_page_of_another_origin_gets_no_socket(run: LiveRun, enter: Enter, origin: str) -> None:
    with pytest.raises(InvalidStatus):
        enter(origin)
    assert request(run, "POST", "/estop", origin=origin, x_robotcore="estop").status == 403
    assert run.result is None


@pytest.mark.parametrize("path", ["/", "/page/page.js"])
def test_a_host_that_is_not_this_machine_gets_nothing(run: LiveRun, path: str) -> None:
    assert request(run, "GET", path, host="evil.example").status == 421
    assert request(run, "GET", path).status == 200


def test_only_a_page_with_a_token_answers_to_an_address_of_the_network(run: LiveRun, start_run: StartRun) -> None:
    assert request(run, "GET", "/", host="192.168.0.7:80").status == 421
    assert request(run, "POST", "/estop", host="192.168.0.7:80", x_robotcore="estop").status == 421
    assert request(start_run(Address(EVERYWHERE)), "GET", "/", host="192.168.0.7:80").status == 200


def test_the_estop_of_a_form_of_another_site_is_refused(run: LiveRun) -> None:
    assert request(run, "POST", "/estop").status == 403
    assert request(run, "GET", "/estop", x_robotcore="estop").status == 405
    assert request(run, "OPTIONS", "/estop", origin="http://evil.example").status == 405
    assert ticks_go_on(run)


def test_the_estop_needs_no_token(public_run: LiveRun) -> None:
    assert request(public_run, "POST", "/estop", x_robotcore="estop").status == 204
    assert isinstance(public_run.wait().error, EmergencyStopError)


def test_the_page_may_load_only_its_own_files(run: LiveRun) -> None:
    policy = request(run, "GET", "/").getheader("content-security-policy") or ""
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "frame-ancestors 'none'" in policy
    assert request(run, "GET", "/page/../server.py").status == 404
    assert request(run, "GET", "/page/%2e%2e/server.py").status == 404


@pytest.mark.parametrize("token", ["", "wrong", "x" * 3000])
def test_a_wrong_token_gets_no_message(public_run: LiveRun, token: str) -> None:
    client = Client(public_run, token=token)
    with pytest.raises(ConnectionClosed) as closed:
        client.socket.recv(10)
    assert closed.value.rcvd
    assert closed.value.rcvd.code == WRONG_TOKEN
    client.close()


def test_a_viewer_with_a_wrong_token_presses_nothing_by_its_socket(public_run: LiveRun) -> None:
    client = Client(public_run, token="wrong")  # noqa: S106
    with suppress(ConnectionClosed):
        client.send(type="estop")
    assert close_code(client) == WRONG_TOKEN
    assert ticks_go_on(public_run)
    client.close()


def test_a_hostile_message_ends_its_sender_and_nothing_else(run: LiveRun, enter: Enter) -> None:
    other = enter()
    for text in HOSTILE:
        client = enter()
        client.socket.send(text)
        assert close_code(client) in {FLOOD, 1007, 1009}, text
    assert other.receive("tick")
    assert ticks_go_on(run)


def test_a_flood_of_messages_ends_its_sender(run: LiveRun, enter: Enter) -> None:
    client = enter()
    with suppress(ConnectionClosed):
        for _ in range(100_000):
            client.send(type="ack", tick=1)
    assert close_code(client) in {FLOOD, 0}
    assert ticks_go_on(run)


def test_too_many_viewers_are_refused(run: LiveRun, enter: Enter) -> None:
    viewers = [enter() for _ in range(MAX_VIEWERS)]
    for viewer in viewers:
        viewer.receive("run")
    assert close_code(enter()) == FULL


def test_a_viewer_who_does_not_read_gets_nothing_more_and_slows_nobody(run: LiveRun, enter: Enter) -> None:
    enter()
    other = enter()
    before = measure_memory(run)
    times = [other.receive("tick")["time"] for _ in range(60)]
    assert max(np.diff(times)) < 0.5
    assert ticks_go_on(run)
    assert measure_memory(run) < before + 20_000_000


def test_pings_without_reading_the_answers_need_no_memory(run: LiveRun, enter: Enter) -> None:
    client = enter()
    client.receive("run")
    before, raw = measure_memory(run), client.socket.socket
    ping = b"\x89\xfd" + b"\x00" * 4 + b"x" * 125
    raw.settimeout(2)
    with suppress(OSError):
        for _ in range(1000):
            raw.sendall(ping * 500)
    assert measure_memory(run) < before + 20_000_000
    assert ticks_go_on(run)


def measure_memory(run: LiveRun) -> int:
    """Return the memory of the page's process, in bytes."""
    process = run.view._page._process
    assert process
    pages = Path(f"/proc/{process.pid}/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def test_a_thousand_hostile_clients_press_nothing(run: LiveRun, enter: Enter) -> None:
    chance, memory = random.Random(7), 0
    attacks = list(list_attacks(run))
    for number in range(1000):
        with suppress(ConnectionClosed, InvalidHandshake, OSError, TimeoutError):
            chance.choice(attacks)()
        if number == 100:
            memory = measure_memory(run)
    assert measure_memory(run) < memory + 20_000_000
    assert run.result is None
    assert ticks_go_on(run)
    client = enter()
    assert client.receive("tick")


def list_attacks(run: LiveRun) -> Iterator[Callable[[], object]]:
    where = urlsplit(run.view.link)

    def send_message(text: str | bytes) -> None:
        client = Client(run)
        client.socket.send(text)
        client.close()

    def send_bytes(data: bytes) -> None:
        with socket.create_connection((str(where.hostname), int(where.port or 0)), timeout=2) as connection:
            connection.sendall(data)

    for text in HOSTILE:
        yield lambda text=text: send_message(text)  # type: ignore[misc]
    head = f"GET /live HTTP/1.1\r\nHost: {where.netloc}\r\n"
    for data in (b"\x00" * 500, b"GET / HTTP/9.9\r\n\r\n", head.encode(), (head + "X: " + "y" * 90_000).encode()):
        yield lambda data=data: send_bytes(data)  # type: ignore[misc]
    yield lambda: Client(run, "http://evil.example")
    yield lambda: request(run, "POST", "/estop", content_length="9" * 12)
    yield lambda: request(run, "POST", "/estop", host="evil.example", x_robotcore="estop")


def test_numbers_that_json_lacks_are_null_on_the_page(run: LiveRun) -> None:
    client = Client(run)
    for _ in range(5):
        text = json.dumps(client.receive("tick"))
        assert "NaN" not in text
        assert "Infinity" not in text


def test_a_picture_that_cannot_be_encoded_is_a_warning_and_the_page_goes_on(run: LiveRun, enter: Enter) -> None:
    client = enter()
    client.receive("run")
    run.view._page.send(Message({"type": "picture", "name": "eye", "shape": [1, 1, 2]}, b"ab"))
    while "cannot show the picture eye" not in client.receive("line")["text"]:
        pass
    assert client.receive("tick")


def test_a_state_that_cannot_be_shown_is_one_warning_and_the_page_goes_on(
    run: LiveRun, enter: Enter, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_arguments: object) -> None:
        raise ZeroDivisionError("no width")

    client = enter()
    client.receive("tick")
    with monkeypatch.context() as patch:
        patch.setattr(SnapshotBuilder, "build_message", fail)
        while "ZeroDivisionError: no width" not in client.receive("line")["text"]:
            pass
    assert client.receive("tick")
    late = enter().receive("history")
    assert sum("no width" in each["text"] for each in late["lines"]) == 1


def test_the_page_ends_after_a_message_that_it_does_not_understand(run: LiveRun, enter: Enter) -> None:
    enter().receive("tick")
    process = run.view._page._process
    assert process
    run.view._page.send(Message({"number": 7}))
    process.wait(5)
    assert ticks_go_on(run)

"""Attack the live page of a run, and measure what the run notices.

    python -m benchmarks.hostile_clients
    python -m benchmarks.hostile_clients --minutes 1.0

A run drives in circles in real time, in a process of its own, and its page needs a token. Meanwhile:

- Clients send hostile messages, spread over the time: wrong sizes, types and numbers with the right token, commands
  with a wrong one, a wrong origin, a wrong host, too many messages, and bytes that are no request.
- A viewer with the right token stops reading. If the page drops it, another one takes its place.
- Sockets without a token flood pings, and others open connections and stay silent.
- Once in a second, a request to press the e-stop without its header asks how soon the page answers.

In the end a press of the e-stop ends the run. A run with the same page and no client is the comparison. The exit
status is 1 if a command passes, or if a measurement misses its bound.
"""

from __future__ import annotations

import http.client
import json
import os
import random
import socket
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Event, Thread
from typing import NamedTuple
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from benchmarks.report import parse_options, print_table
from robotcore import RunRequest, run
from robotcore.live.access import ESTOP_HEADER
from robotcore.live.address import Address
from robotcore.live.connections import MAX_CONNECTIONS
from robotcore.live.live_view import LiveView
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from tests.robotcore.live.hostile_messages import HOSTILE
from tests.robotcore.live.live_run import Circles

TICK_SHARE, MEMORY_MB, ESTOP_S = 1.1, 20.0, 0.5
"""The bounds: the time of a tick as a multiple of that without clients, the growth of each process, and the worst
answer to a press of the e-stop."""

COMPARISON_S = 60.0
"""The longest time of the run without clients."""

FLOODERS, FLOOD_PERIOD_S = 30, 1.0
PING = b"\x89\x80" + b"\x00" * 4
COMMANDS = (
    {"type": "take"},
    {"type": "drive", "linear": 1.0, "angular": 0.0, "sent": 0.0},
    {"type": "actuate", "device": "pan", "value": [0.5], "sent": 0.0},
    {"type": "pace", "speed": 5.0},
    {"type": "pace", "is_paused": True},
    {"type": "estop"},
)
EXPECTED = (ConnectionClosed, InvalidHandshake, http.client.HTTPException, OSError, TimeoutError)
"""What a client gets that the page refuses."""


class Begun(NamedTuple):
    """A run that has begun: the place of its page, and its processes."""

    port: int
    token: str
    run: int
    page: int


class Ended(NamedTuple):
    """A run that has ended.

    p50_us: the median time of a tick without its sleep.
    commands: the number of commands of clients that reached the run before the e-stop.
    """

    p50_us: float
    ticks: int
    overruns: int
    commands: int
    reason: str


class Announcer:
    """An observer that sends the place of the page with the first tick."""

    def __init__(self, pipe: Connection, view: LiveView) -> None:
        self._pipe, self._view = pipe, view
        self.has_announced = False

    def begin(self, run: RunContext) -> None:
        self.run = run

    def tick(self, record: TickRecord) -> None:
        process = self._view._page._process  # noqa: SLF001  its memory is measured
        if not self.has_announced and process:
            link = urlsplit(self._view.link)
            self._pipe.send(Begun(link.port or 0, link.fragment.removeprefix("token="), os.getpid(), process.pid))
            self.has_announced = True

    def end(self, result: RunResult) -> None:
        pace, operator = self.run.pace, self.run.operator
        assert pace
        assert operator
        commands = operator.calls + (pace.speed != 1.0) + pace.is_paused
        times = result.tick_times_us
        p50 = sum(each["p50"] for phase, each in times.items() if phase != "sleep")
        self._pipe.send(Ended(p50, result.ticks, result.overruns, commands, result.reason))


def hold_run(pipe: Connection, seconds: float) -> None:
    """Run with a page, in a process of its own."""
    view = LiveView(Address("0.0.0.0"))  # noqa: S104  such a page has a token
    request = RunRequest(Circles, world="open", realtime=True, has_operator=True, timeout_s=seconds)
    with redirect_stdout(None):  # the app prints a line
        run(request, [Announcer(pipe, view), view])


@contextmanager
def start_run(seconds: float) -> Iterator[Connection]:
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=hold_run, args=(theirs, seconds))
    process.start()
    theirs.close()
    try:
        yield ours
    except BaseException:
        process.terminate()
        raise
    finally:
        process.join()


def read_memory(process: int) -> float:
    """Return the memory of a process in MB."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


class Attacker:
    """The hostile clients of a run's page."""

    def __init__(self, begun: Begun, seed: int) -> None:
        self._port, self._token = begun.port, begun.token
        self._host = f"127.0.0.1:{begun.port}"
        self._chance = random.Random(seed)
        self._attacks = list(self._list_attacks())
        self._ended = Event()
        self._threads = [Thread(target=each) for each in (self._flood, self._stay_silent, self._stop_reading)]
        self.sent = self.dropped = 0
        """The number of hostile messages, and of viewers who did not read and were dropped."""

    def __enter__(self) -> Attacker:
        for each in self._threads:
            each.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        for each in self._threads:
            each.join()

    def send(self) -> None:
        """Send one hostile message."""
        self.sent += 1
        with suppress(*EXPECTED):
            self._chance.choice(self._attacks)()

    def press_estop(self, **headers: str) -> tuple[int, float]:
        """Return the status of the answer to a press of the e-stop, 0 without one, and the time until it came."""
        began, status = time.monotonic(), 0
        with suppress(*EXPECTED):
            status = self._post(headers)
        return status, time.monotonic() - began

    def _post(self, headers: dict[str, str]) -> int:
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=30)
        connection.request("POST", "/estop", headers={name.replace("_", "-"): each for name, each in headers.items()})
        status = connection.getresponse().status
        connection.close()
        return status

    @contextmanager
    def _connect(self, token: str, origin: str = "") -> Iterator[ClientConnection]:
        url = f"ws://{self._host}/live"
        with connect(url, origin=Origin(origin or f"http://{self._host}"), max_size=None, close_timeout=0.5) as client:
            client.send(json.dumps({"type": "hello", "token": token}))
            yield client

    def _send_messages(self, token: str, *messages: str | bytes, origin: str = "") -> None:
        with self._connect(token, origin) as client:
            for each in messages:
                client.send(each)

    def _send_bytes(self, data: bytes) -> None:
        with socket.create_connection(("127.0.0.1", self._port), timeout=5) as wire:
            wire.sendall(data)

    def _list_attacks(self) -> Iterator[Callable[[], object]]:
        for text in HOSTILE:
            yield lambda text=text: self._send_messages(self._token, text)  # type: ignore[misc]
        for token in ("", "wrong", "x" * 3000):
            commands = [json.dumps(each) for each in COMMANDS]
            yield lambda token=token, commands=commands: self._send_messages(token, *commands)  # type: ignore[misc]
        yield lambda: self._send_messages(self._token, *['{"type": "ack", "tick": 1}'] * 2000)
        yield lambda: self._send_messages(self._token, origin="http://evil.example")
        yield lambda: self._post({"host": "evil.example", ESTOP_HEADER[0]: ESTOP_HEADER[1]})
        yield lambda: self._post({"origin": "http://evil.example", ESTOP_HEADER[0]: ESTOP_HEADER[1]})
        head = f"GET /live HTTP/1.1\r\nHost: {self._host}\r\n".encode()
        for data in (b"\x00" * 500, b"GET / HTTP/9.9\r\n\r\n", head, head + b"X: " + b"y" * 90_000):
            yield lambda data=data: self._send_bytes(data)  # type: ignore[misc]

    def _flood(self) -> None:
        """Flood pings from sockets without a token, again and again."""
        key = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
        origin = f"Sec-WebSocket-Version: 13\r\nOrigin: http://{self._host}\r\n\r\n"
        request = f"GET /live HTTP/1.1\r\nHost: {self._host}\r\n{key}{origin}".encode()
        while not self._ended.wait(FLOOD_PERIOD_S):
            with ExitStack() as stack, suppress(*EXPECTED):
                for _ in range(FLOODERS):
                    wire = stack.enter_context(socket.create_connection(("127.0.0.1", self._port), timeout=5))
                    wire.sendall(request)
                    wire.recv(1000)
                    wire.setblocking(False)
                    with suppress(OSError):
                        wire.send(PING * 40_000)

    def _stay_silent(self) -> None:
        """Hold more connections than the page allows."""
        while not self._ended.is_set():
            with ExitStack() as stack, suppress(*EXPECTED):
                for _ in range(2 * MAX_CONNECTIONS):
                    wire = socket.create_connection(("127.0.0.1", self._port), timeout=5)
                    stack.enter_context(wire).sendall(b"GET / HTTP/1.1\r\nX: ")
                self._ended.wait(2.0)

    def _stop_reading(self) -> None:
        """Hold a viewer that does not read."""
        while not self._ended.is_set():
            with suppress(*EXPECTED), self._connect(self._token) as client:
                while not self._ended.wait(0.5):
                    client.send('{"type": "ack", "tick": 1}')
            self.dropped += not self._ended.is_set()


def measure_alone(seconds: float) -> Ended:
    with start_run(seconds) as pipe:
        pipe.recv()
        ended: Ended = pipe.recv()
    return ended


def measure_attacked(seconds: float, messages: int) -> bool:
    alone = measure_alone(min(seconds, COMPARISON_S))
    answers, memory = list[tuple[int, float]](), list[tuple[float, float]]()
    with start_run(seconds + 600) as pipe:
        begun: Begun = pipe.recv()
        with Attacker(begun, seed=7) as attacker:
            start = due = time.monotonic()
            while (passed := time.monotonic() - start) < seconds:
                while attacker.sent < messages * passed / seconds:
                    attacker.send()
                if time.monotonic() >= due:
                    due += 1.0
                    answers.append(attacker.press_estop())
                    memory.append((read_memory(begun.page), read_memory(begun.run)))
                time.sleep(0.02)
            while attacker.sent < messages:
                attacker.send()
            answers.append(attacker.press_estop(**{ESTOP_HEADER[0]: ESTOP_HEADER[1]}))
        ended: Ended = pipe.recv()
    ticks = [format_ticks("no client", alone), format_ticks(f"{attacker.sent} hostile messages", ended)]
    print_table(("clients", "ticks", "p50 of a tick, µs", "overruns", "commands that passed"), ticks)
    growth = print_memory(memory)
    delays = [delay for status, delay in answers if status]
    times = (f"{1000 * each:.1f}" for each in (statistics.median(delays), max(delays)))
    columns = ("presses of the e-stop", "answered", "median, ms", "worst, ms", "viewers dropped who did not read")
    print_table(columns, [(str(len(answers)), str(len(delays)), *times, str(attacker.dropped))])
    is_stopped = answers[-1][0] == http.client.NO_CONTENT and "e-stop" in ended.reason
    is_fast = ended.p50_us <= TICK_SHARE * alone.p50_us and len(delays) == len(answers) and max(delays) <= ESTOP_S
    return is_stopped and is_fast and not ended.commands and growth <= MEMORY_MB


def print_memory(memory: list[tuple[float, float]]) -> float:
    """Print the memory of the page and the run, and return the greatest growth after a tenth of the time, in MB."""
    rows, growths = [], list[float]()
    for name, values in zip(("page", "run"), zip(*memory[len(memory) // 10 :], strict=True), strict=True):
        growths.append(max(values) - values[0])
        rows.append((name, *(f"{each:.1f}" for each in (values[0], max(values), values[-1]))))
    print_table(("process", "memory after a tenth of the time, MB", "greatest later, MB", "at the end, MB"), rows)
    return max(growths)


def format_ticks(clients: str, ended: Ended) -> tuple[str, ...]:
    return clients, str(ended.ticks), f"{ended.p50_us:.0f}", str(ended.overruns), str(ended.commands)


def main() -> int:
    assert __doc__
    options = parse_options(__doc__, minutes=10.0, messages=1000)
    return int(not measure_attacked(60 * options.minutes, options.messages))


if __name__ == "__main__":
    sys.exit(main())

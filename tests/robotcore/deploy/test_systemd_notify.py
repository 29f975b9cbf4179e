from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from socket import AF_UNIX, SOCK_DGRAM, socket

import pytest

from robotcore.deploy.systemd_notify import Notifier
from robotcore.errors import EmergencyStopError
from robotcore.hal.clock import SteppedClock
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import MonitoredValue, TickRecord

RATE_HZ = 20.0


class Listener:
    """The socket of systemd."""

    def __init__(self, address: str) -> None:
        self._socket = socket(AF_UNIX, SOCK_DGRAM)
        self._socket.bind(address)
        self._socket.setblocking(False)

    def read_messages(self) -> list[str]:
        """Return the messages since the last call."""
        messages = []
        try:
            while True:
                messages.append(self._socket.recv(4096).decode())
        except BlockingIOError:
            return messages

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def path(tmp_path: Path) -> str:
    return str(tmp_path / "notify")


@pytest.fixture
def systemd(path: str) -> Iterator[Listener]:
    listener = Listener(path)
    yield listener
    listener.close()


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock(RATE_HZ, lambda _: None)


def run_ticks(
    notifier: Notifier, clock: SteppedClock, seconds: float, state: str = "search", systemd: Listener | None = None
) -> list[str]:
    """Run ticks, and return the messages to ``systemd``, read after each tick: a socket queues only ten."""
    messages = []
    for tick in range(round(seconds * RATE_HZ)):
        notifier.tick(TickRecord(tick, clock.now(), state, None, None, ()))
        clock.sleep_until(clock.now() + 1 / RATE_HZ)
        messages += systemd.read_messages() if systemd else []
    return messages


def result(outcome: Outcome = Outcome.SUCCESS, reason: str = "") -> RunResult:
    return RunResult("an-app", "kinematic", "rover", "open", 1, outcome, 0, reason)


def test_first_tick_reports_ready_and_alive(systemd: Listener, path: str, clock: SteppedClock) -> None:
    notifier = Notifier(path, 10.0, clock)
    assert systemd.read_messages() == []
    run_ticks(notifier, clock, 0.2)
    assert systemd.read_messages() == ["READY=1", "WATCHDOG=1", "STATUS=search, 0 s"]


def test_status_names_a_lost_device_and_the_voltage_of_a_battery(
    systemd: Listener, path: str, clock: SteppedClock
) -> None:
    record = TickRecord(0, 0.0, "search", None, None, (), lost="nose", monitored={"cells": MonitoredValue(7.384, "V")})
    Notifier(path, clock=clock).tick(record)
    assert "STATUS=waiting for nose, 0 s, 7.38 V" in systemd.read_messages()


def test_first_tick_with_an_error_is_not_ready(systemd: Listener, path: str, clock: SteppedClock) -> None:
    notifier = Notifier(path, clock=clock)
    with suppress(EmergencyStopError):
        try:
            raise EmergencyStopError("a test")
        finally:
            run_ticks(notifier, clock, 0.05)
    assert systemd.read_messages() == ["STATUS=search, 0 s"]


@pytest.mark.parametrize("watchdog_s, fed", [(0.1, 200), (1.0, 40), (10.0, 20)])
def test_watchdog_is_reset_four_times_within_its_limit_and_twice_a_second(
    systemd: Listener, path: str, clock: SteppedClock, watchdog_s: float, fed: int
) -> None:
    messages = run_ticks(Notifier(path, watchdog_s, clock), clock, 10.0, systemd=systemd)
    assert messages.count("WATCHDOG=1") == fed


def test_status_is_one_short_line_each_second(systemd: Listener, path: str, clock: SteppedClock) -> None:
    run_ticks(Notifier(path, clock=clock), clock, 3.0, f"lost\nREADY=1 \ud800 {'x' * 1000}")
    statuses = [each for each in systemd.read_messages() if each.startswith("STATUS=")]
    assert len(statuses) == 3
    assert all(each.startswith("STATUS=lost READY=1 ? xxx") and "\n" not in each for each in statuses)
    assert max(map(len, statuses)) <= 210


def test_end_reports_stopping_and_the_reason(systemd: Listener, path: str) -> None:
    Notifier(path).end(result(Outcome.STOPPED, "e-stop: a test"))
    Notifier(path).end(result())
    assert systemd.read_messages() == [
        "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000\nSTATUS=stopped: e-stop: a test",
        "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000\nSTATUS=success",
    ]


def test_abstract_socket_works(clock: SteppedClock) -> None:
    name = f"robotcore-{os.getpid()}"
    systemd = Listener(f"\0{name}")
    run_ticks(Notifier(f"@{name}", clock=clock), clock, 0.05)
    assert systemd.read_messages()[0] == "READY=1"
    systemd.close()


def test_full_socket_does_not_block_and_messages_are_repeated(
    systemd: Listener, path: str, clock: SteppedClock
) -> None:
    notifier = Notifier(path, 10.0, clock)
    with socket(AF_UNIX, SOCK_DGRAM) as other:
        other.setblocking(False)
        with suppress(BlockingIOError):
            while True:
                other.sendto(b"noise", path)
    run_ticks(notifier, clock, 0.1)
    assert set(systemd.read_messages()) == {"noise"}
    run_ticks(notifier, clock, 0.05)
    assert systemd.read_messages() == ["READY=1", "WATCHDOG=1", "STATUS=search, 0 s"]


def test_variables_of_systemd_are_deleted() -> None:
    environment = {"NOTIFY_SOCKET": "@here", "WATCHDOG_USEC": "8000000", "WATCHDOG_PID": str(os.getpid()), "HOME": "/"}
    assert Notifier.from_environment(environment)
    assert environment == {"HOME": "/"}


@pytest.mark.parametrize(
    "environment",
    [
        {},
        {"NOTIFY_SOCKET": ""},
        {"NOTIFY_SOCKET": "vsock:2:1234"},
        {"NOTIFY_SOCKET": "@here", "WATCHDOG_USEC": "8000000", "WATCHDOG_PID": "1"},
    ],
)
def test_process_without_a_socket_of_its_own_has_no_notifier(environment: dict[str, str]) -> None:
    assert Notifier.from_environment(environment) is None


@pytest.mark.parametrize("period", ["", "0", "soon"])
def test_watchdog_without_a_limit_is_ignored(systemd: Listener, path: str, period: str) -> None:
    notifier = Notifier.from_environment({"NOTIFY_SOCKET": path, "WATCHDOG_USEC": period})
    assert notifier
    notifier.tick(TickRecord(0, 0.0, "search", None, None, ()))
    assert systemd.read_messages() == ["READY=1", "STATUS=search, 0 s"]

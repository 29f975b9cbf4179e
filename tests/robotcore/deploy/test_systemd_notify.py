from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from socket import AF_UNIX, SOCK_DGRAM, socket

import pytest

from robotcore.deploy.systemd_notify import Notifier
from robotcore.errors import EmergencyStopError
from robotcore.hal.clock import SteppedClock
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import TickRecord

RATE_HZ = 20.0


class Listener:
    """Systemd's end of the line."""

    def __init__(self, address: str) -> None:
        self._socket = socket(AF_UNIX, SOCK_DGRAM)
        self._socket.bind(address)
        self._socket.setblocking(False)

    def heard(self) -> list[str]:
        """Return what has come since it was asked last, a message each."""
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


def ticking(
    notifier: Notifier, clock: SteppedClock, seconds: float, state: str = "search", systemd: Listener | None = None
) -> list[str]:
    """Tick, and return what ``systemd`` has heard meanwhile: the system keeps ten messages for it, and no more."""
    heard = []
    for tick in range(round(seconds * RATE_HZ)):
        notifier.tick(TickRecord(tick, clock.now(), state, None, None, ()))
        clock.sleep_until(clock.now() + 1 / RATE_HZ)
        heard += systemd.heard() if systemd else []
    return heard


def failing(error: Exception, tick: Callable[[], object]) -> None:
    """Note a tick while an error ends the run in it, as the loop does."""
    try:
        raise error
    finally:
        tick()


def result(outcome: Outcome = Outcome.SUCCESS, reason: str = "") -> RunResult:
    return RunResult("an-app", "kinematic", "rover", "open", 1, outcome, 0, reason)


def test_the_first_tick_is_ready_and_alive(systemd: Listener, path: str, clock: SteppedClock) -> None:
    notifier = Notifier(path, 10.0, clock)
    assert systemd.heard() == []
    ticking(notifier, clock, 0.2)
    assert systemd.heard() == ["READY=1", "WATCHDOG=1", "STATUS=search, 0 s"]


def test_the_status_tells_the_voltage_where_a_battery_does(systemd: Listener, path: str, clock: SteppedClock) -> None:
    notifier = Notifier(path, clock=clock)
    notifier.tick(TickRecord(0, 0.0, "search", None, None, (), voltages={"cells": 7.384}))
    assert systemd.heard() == ["READY=1", "STATUS=search, 0 s, 7.38 V"]


def test_the_status_tells_what_is_waited_for(systemd: Listener, path: str, clock: SteppedClock) -> None:
    Notifier(path, clock=clock).tick(TickRecord(0, 0.0, "search", None, None, (), lost="nose"))
    assert "STATUS=waiting for nose, 0 s" in systemd.heard()


def test_a_first_tick_that_fails_is_not_ready(systemd: Listener, path: str, clock: SteppedClock) -> None:
    notifier = Notifier(path, clock=clock)
    with pytest.raises(EmergencyStopError):
        failing(EmergencyStopError("a test"), lambda: ticking(notifier, clock, 0.05))
    assert systemd.heard() == ["STATUS=search, 0 s"]


@pytest.mark.parametrize("watchdog_s, fed", [(1.0, 40), (2.0, 20), (10.0, 20)])
def test_the_watchdog_is_fed_four_times_in_its_time_twice_a_second_and_no_oftener(
    systemd: Listener, path: str, clock: SteppedClock, watchdog_s: float, fed: int
) -> None:
    heard = ticking(Notifier(path, watchdog_s, clock), clock, 10.0, systemd=systemd)
    assert heard.count("WATCHDOG=1") == fed


def test_a_watchdog_that_is_quicker_than_the_ticks_is_fed_at_each(
    systemd: Listener, path: str, clock: SteppedClock
) -> None:
    heard = ticking(Notifier(path, 0.1, clock), clock, 1.0, systemd=systemd)
    assert heard.count("WATCHDOG=1") == RATE_HZ


def test_without_a_watchdog_none_is_fed(systemd: Listener, path: str, clock: SteppedClock) -> None:
    assert "WATCHDOG=1" not in ticking(Notifier(path, clock=clock), clock, 10.0, systemd=systemd)


def test_the_state_is_reported_once_a_second_in_one_short_line(
    systemd: Listener, path: str, clock: SteppedClock
) -> None:
    ticking(Notifier(path, clock=clock), clock, 3.0, f"lost\nREADY=1 \ud800 {'x' * 1000}")
    statuses = [each for each in systemd.heard() if each.startswith("STATUS=")]
    assert len(statuses) == 3
    assert all(each.startswith("STATUS=lost READY=1 ? xxx") and "\n" not in each for each in statuses)
    assert max(map(len, statuses)) <= 210


def test_at_the_end_it_is_stopping_for_the_reason_of_the_run(systemd: Listener, path: str) -> None:
    Notifier(path).end(result(Outcome.STOPPED, "e-stop: a test"))
    Notifier(path).end(result())
    assert systemd.heard() == [
        "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000\nSTATUS=stopped: e-stop: a test",
        "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000\nSTATUS=success",
    ]


def test_an_abstract_socket_is_reported_too(clock: SteppedClock) -> None:
    name = f"robotcore-{os.getpid()}"
    systemd = Listener(f"\0{name}")
    ticking(Notifier(f"@{name}", clock=clock), clock, 0.05)
    assert systemd.heard()[0] == "READY=1"
    systemd.close()


def test_nobody_waits_for_a_systemd_that_does_not_listen_and_what_it_missed_is_reported_again(
    systemd: Listener, path: str, clock: SteppedClock
) -> None:
    notifier = Notifier(path, 10.0, clock)
    with socket(AF_UNIX, SOCK_DGRAM) as other:
        other.setblocking(False)
        with suppress(BlockingIOError):
            while True:
                other.sendto(b"noise", path)
    ticking(notifier, clock, 0.1)
    assert set(systemd.heard()) == {"noise"}
    ticking(notifier, clock, 0.05)
    assert systemd.heard() == ["READY=1", "WATCHDOG=1", "STATUS=search, 0 s"]


def test_a_socket_that_is_gone_does_not_matter(path: str, clock: SteppedClock) -> None:
    notifier = Notifier(path, 1.0, clock)
    ticking(notifier, clock, 1.0)
    notifier.end(result())


def test_a_service_s_environment_is_taken_out_so_that_nothing_started_later_finds_it() -> None:
    environment = {"NOTIFY_SOCKET": "@here", "WATCHDOG_USEC": "8000000", "WATCHDOG_PID": str(os.getpid()), "HOME": "/"}
    assert Notifier.of(environment)
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
def test_a_process_that_is_not_asked_to_tells_nobody(environment: dict[str, str]) -> None:
    assert Notifier.of(environment) is None


@pytest.mark.parametrize("period", ["", "0", "soon"])
def test_a_watchdog_without_a_time_is_none(systemd: Listener, path: str, period: str) -> None:
    notifier = Notifier.of({"NOTIFY_SOCKET": path, "WATCHDOG_USEC": period})
    assert notifier
    notifier.tick(TickRecord(0, 0.0, "search", None, None, ()))
    assert systemd.heard() == ["READY=1", "STATUS=search, 0 s"]

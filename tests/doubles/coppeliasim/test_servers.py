"""Clients of the servers: stepping clients, silent clients, invalid messages, and the double as a process."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress

import pytest

from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.legacy.codec import encode_packets
from tests.doubles.coppeliasim.replay import EXECUTED, WAIT, ZmqClient, connect_clients
from tests.doubles.coppeliasim.scenes import default_scene

PATIENCE_S = 20


@pytest.fixture
def double() -> Iterator[Double]:
    with Double(default_scene()) as double:
        yield double


@pytest.fixture
def pair(double: Double) -> Iterator[list[ZmqClient]]:
    with connect_clients(double.zmq_port, 2) as clients:
        yield clients


def read_time(client: ZmqClient) -> float:
    return float(client.call("sim.getSimulationTime")["ret"][0])


def await_time(client: ZmqClient) -> None:
    """Wait until the simulation's time advances."""
    clock = MonotonicClock()
    while read_time(client) == 0.0:
        assert clock.now() < PATIENCE_S, "time stands still"
        clock.sleep_until(clock.now() + 0.01)


def test_step_waits_for_all_stepping_clients(pair: list[ZmqClient]) -> None:
    one, other = pair
    for each in pair:
        assert each.call("sim.setStepping", True) == {"ret": [0]}
    one.call("sim.startSimulation")
    assert one.call("sim.step")["func"] == WAIT
    assert one.call("sim.getSimulationTime")["func"] == WAIT
    assert read_time(other) == 0.0
    assert other.finish(other.call("sim.step")) == {"ret": {}}
    assert one.call(EXECUTED) == {"ret": {}}
    assert read_time(one) == 0.05


def test_stop_by_another_client_ends_steps(pair: list[ZmqClient]) -> None:
    one, other = pair
    for each in pair:
        each.call("sim.setStepping", True)
    one.call("sim.startSimulation")
    one.call("sim.step")
    assert other.finish(other.call("sim.stopSimulation", True)) == {"ret": {}}
    assert one.finish(one.call(EXECUTED)) == {"ret": {}}
    assert one.call("sim.getSimulationState") == {"ret": [0]}


@pytest.mark.parametrize("leaves", ["by a message", "silently"])
def test_client_that_leaves_holds_nothing(pair: list[ZmqClient], leaves: str) -> None:
    one, other = pair
    one.call("sim.setStepping", True, timeout=0.2)
    one.call("sim.startSimulation")
    if leaves == "by a message":
        assert one.call("_*end*_") == {}
    await_time(other)


def test_invalid_zmq_request_is_answered(pair: list[ZmqClient]) -> None:
    one, other = pair
    assert "err" in one.exchange_bytes(b"\xff\x00nonsense")
    assert one.exchange_bytes(b"\xa0")["success"] is False
    refused = (("getObject", 5), ("setShapeColor", 2, None, 0, ["red"] * 3), ("getObjectUid", 1), ("fly", 1))
    assert ["err" in other.call(f"sim.{name}", *arguments) for name, *arguments in refused] == [True] * 4
    assert other.call("sim.getSimulationState") == {"ret": [0]}


def test_invalid_legacy_message_closes_the_connection(double: Double) -> None:
    for message in (b"\0\1\4\0\0\0abcd", encode_packets(bytes(17)), encode_packets(b"\0\0\x0b" + bytes(30))):
        with socket.create_connection(("127.0.0.1", double.legacy_port), PATIENCE_S) as line:
            line.sendall(message)
            with suppress(ConnectionResetError):
                assert line.recv(1) == b""


@pytest.mark.slow
def test_process_serves_a_drawn_world_until_it_is_terminated() -> None:
    options = ["--zmq-port", "0", "--legacy-port", "0", "--robot", "rover", "--world", "arena", "--seed", "7"]
    command = [sys.executable, "-m", "tests.doubles.coppeliasim", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        ports = re.fullmatch(r"coppeliasim double: zmq (\d+), legacy (\d+)\n", process.stdout.readline())
        try:
            assert ports
            with connect_clients(int(ports[1]), 1) as (client,):
                assert client.call("sim.getObject", "/rover/left_motor")["ret"][0] >= 0
            process.send_signal(signal.SIGTERM)
            assert process.wait(PATIENCE_S) == 0
        finally:
            process.kill()

"""The double as a separate process."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.doubles.coppeliasim.zmq.raw_client import await_time, connect_clients

PATIENCE_S = 20


@contextmanager
def running(*options: str) -> Iterator[tuple[subprocess.Popen[str], int, int]]:
    """Start a double as a process, and yield the process, its ZeroMQ port and its legacy port."""
    command = [sys.executable, "-m", "tests.doubles.coppeliasim", "--zmq-port", "0", "--legacy-port", "0", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        ports = re.fullmatch(r"coppeliasim double: zmq (\d+), legacy (\d+)\n", process.stdout.readline())
        assert ports
        try:
            yield process, int(ports[1]), int(ports[2])
        finally:
            process.kill()


@pytest.mark.slow
def test_process_serves_a_drawn_world_until_it_is_terminated() -> None:
    with running("--robot", "rover", "--world", "arena", "--seed", "7", "--running") as (process, port, _):
        with connect_clients(port, "one") as (client,):
            assert client.call("sim.getObject", "/rover/left_motor")["ret"][0] >= 0
            assert client.call("sim.getSimulationState")["ret"][0] & 16
            await_time(client)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0

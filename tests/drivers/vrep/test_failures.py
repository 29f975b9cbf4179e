"""Tests of runs whose simulator fails. Each run ends soon with a specific error, and the next run works."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import robotcore.description
from drivers.vrep.wire.errors import (
    RemoteApiError,
    ServerLostError,
    ServerTimeoutError,
    SimulationHaltedError,
)
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.legacy.faults import DropConnection, Fault, Hang
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator, State
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.drivers.vrep.test_apps import create_arena
from tests.robotcore.runs import CallOnce

BOUND_S = 20.0
"""The time after which a run counts as hanging, in seconds.

On an idle machine, errors are raised within two seconds.
"""


@pytest.fixture
def simulator() -> Simulator:
    return create_arena("rover", 1)


@pytest.fixture
def server(simulator: Simulator) -> Iterator[LegacyServer]:
    with LegacyServer(simulator) as server:
        yield server


@pytest.fixture
def slow_rover(tmp_path: Path) -> str:
    """Return the file of a rover with long time limits, for busy machines."""
    rover = Path(robotcore.description.__file__).with_name("robots") / "rover.toml"
    file = tmp_path / "slow_rover.toml"
    file.write_text(rover.read_text().replace("max_age_s = 1.0\n", "max_age_s = 5.0\nanswer_s = 5.0\n"))
    return str(file)


def drive(
    port: int, *observers: CallOnce, robot: str = "rover", duration_s: float = 60.0, **options: object
) -> RunResult:
    clock = MonotonicClock()
    settings, options = {"duration_s": duration_s}, {"port": port, **options}
    request = RunRequest("avoid-obstacles", "vrep", robot, settings=settings, options=options)
    result = run(request, observers)
    assert duration_s < BOUND_S or clock.now() < BOUND_S
    return result


@pytest.mark.slow
@pytest.mark.parametrize("stepped", [True, False])
@pytest.mark.parametrize("fault, error", [(DropConnection, ServerLostError), (Hang, ServerTimeoutError)])
def test_server_that_fails_in_a_run_ends_it_and_the_next_run_works(
    server: LegacyServer, fault: Callable[[], Fault], error: type[RemoteApiError], slow_rover: str, *, stepped: bool
) -> None:
    robot = "rover" if error is ServerTimeoutError else slow_rover
    result = drive(server.port, CallOnce(lambda: server.service.fail(fault())), robot=robot, stepped=stepped)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert type(result.error) is error
    server.service.fail(None)
    server.restart()
    again = drive(server.port, robot=slow_rover, duration_s=0.3, stepped=stepped)
    assert again.outcome is Outcome.SUCCESS, again.reason


@pytest.mark.slow
@pytest.mark.parametrize(
    "halt, kind",
    [(Simulator.stop, "simulation-stopped"), (Simulator.pause, "simulation-paused")],
    ids=["stopped", "paused"],
)
@pytest.mark.parametrize("stepped", [True, False])
def test_simulation_that_the_user_halts_ends_the_run(
    simulator: Simulator,
    server: LegacyServer,
    halt: Callable[[Simulator], None],
    kind: str,
    slow_rover: str,
    *,
    stepped: bool,
) -> None:
    def halt_locked() -> None:
        with simulator.lock:
            halt(simulator)

    result = drive(server.port, CallOnce(halt_locked), robot=slow_rover, stepped=stepped)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, SimulationHaltedError)
    assert result.error.kind == kind


@pytest.mark.slow
def test_simulation_whose_time_does_not_advance_is_started_again(
    simulator: Simulator, server: LegacyServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts: list[float] = []
    original_start = simulator.start

    def start() -> None:
        starts.append(simulator.time)
        original_start()
        if len(starts) == 1:
            simulator.hold("nobody")

    monkeypatch.setattr(simulator, "start", start)
    result = drive(server.port, duration_s=0.3)
    assert result.outcome is Outcome.SUCCESS, result.reason
    assert len(starts) > 1


class InterruptBeforeReply:
    """Sends SIGINT to this process before a delayed reply."""

    def __init__(self, server: LegacyServer) -> None:
        self._server = server

    def send(self, line: socket.socket, answer: bytes) -> None:
        self._server.service.fail(None)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        line.sendall(answer)


@pytest.mark.slow
@pytest.mark.parametrize("stepped", [True, False])
def test_signal_during_an_exchange_stops_wheels_and_simulation(
    simulator: Simulator, server: LegacyServer, slow_rover: str, *, stepped: bool
) -> None:
    result = drive(
        server.port,
        CallOnce(lambda: server.service.fail(InterruptBeforeReply(server))),
        robot=slow_rover,
        stepped=stepped,
    )
    left = simulator.graph.find("/rover/left_motor")
    assert isinstance(left, Joint)
    assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 128 + signal.SIGINT)
    assert (left.target_velocity, simulator.state) == (0.0, State.STOPPED)


@pytest.mark.slow
@pytest.mark.parametrize("stepped", ["true", "false"])
def test_killed_run_leaves_no_wheel_turning(simulator: Simulator, server: LegacyServer, stepped: str) -> None:
    command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", "--backend", "vrep"]
    options = ["--port", str(server.port), "--option", f"stepped={stepped}", "--set", "duration_s=600", "--realtime"]
    with simulator.lock:
        simulator.start()
    left = simulator.graph.find("/rover/left_motor")
    assert isinstance(left, Joint)
    with subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as app:
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: left.target_velocity > 0, 30)
        app.send_signal(signal.SIGKILL)
        app.wait()
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: left.target_velocity == 0, 10)

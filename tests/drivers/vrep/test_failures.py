"""What becomes of a run whose simulator fails: an error by name, soon, and then all is well again."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

import robotcore.description
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.legacy.faults import CutReplies, DropConnection, Fault, Hang, SendGarbage
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State
from tests.drivers.vrep.test_apps import arena
from tests.robotcore.runs import Once

BOUND_S = 20.0
"""Against a hang only: errors come within two seconds on a machine that is not busy."""


@pytest.fixture
def simulator() -> Simulator:
    return arena("rover", 1)


@pytest.fixture
def server(simulator: Simulator) -> Iterator[LegacyServer]:
    with LegacyServer(simulator) as server:
        yield server


@pytest.fixture
def patient(tmp_path: Path) -> str:
    """Return the file of a rover that lets a server take its time: a machine may have other things to do."""
    rover = Path(robotcore.description.__file__).with_name("robots") / "rover.toml"
    file = tmp_path / "patient.toml"
    file.write_text(rover.read_text().replace("max_age_s = 1.0\n", "max_age_s = 5.0\nanswer_s = 5.0\n"))
    return str(file)


def drive(port: int, *observers: Once, robot: str = "rover", duration_s: float = 60.0, **options: object) -> RunResult:
    clock = MonotonicClock()
    settings, options = {"duration_s": duration_s}, {"port": port, **options}
    request = RunRequest("avoid-obstacles", "vrep", robot, settings=settings, options=options)
    result = run(request, observers)
    assert duration_s < BOUND_S or clock.now() < BOUND_S
    return result


def test_dead_server_is_reported_with_what_to_do(server: LegacyServer) -> None:
    port = server.port
    server.close()
    result = drive(port)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert f"nobody answers at 127.0.0.1:{port}" in result.reason
    assert "Start the simulator" in result.reason


@pytest.mark.parametrize("stepped", [True, False])
@pytest.mark.parametrize(
    "fault, named",
    [
        (DropConnection, "is gone"),
        (Hang, "has not answered"),
        (partial(CutReplies, 3), "has not answered"),
        (partial(SendGarbage, b"HTTP/1.1 400 Bad Request\r\n\r\n"), "no reply of the legacy remote API"),
    ],
    ids=["dies", "hangs", "cuts", "babbles"],
)
def test_server_that_fails_in_a_run_ends_it_by_name_and_the_next_run_works(
    server: LegacyServer, fault: Callable[[], Fault], named: str, patient: str, *, stepped: bool
) -> None:
    robot = "rover" if named == "has not answered" else patient
    result = drive(server.port, Once(lambda: server.service.fail(fault())), robot=robot, stepped=stepped)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert named in result.reason
    server.service.fail(None)
    server.restart()
    again = drive(server.port, robot=patient, duration_s=0.3, stepped=stepped)
    assert again.outcome is Outcome.SUCCESS, again.reason


@pytest.mark.parametrize(
    "deed, named", [(Simulator.stop, "stopped"), (Simulator.pause, "paused")], ids=["stopped", "paused"]
)
@pytest.mark.parametrize("stepped", [True, False])
def test_simulation_that_somebody_halts_ends_the_run_by_name(
    simulator: Simulator,
    server: LegacyServer,
    deed: Callable[[Simulator], None],
    named: str,
    patient: str,
    *,
    stepped: bool,
) -> None:
    def halt() -> None:
        with simulator.lock:
            deed(simulator)

    result = drive(server.port, Once(halt), robot=patient, stepped=stepped)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert f"the simulation was {named}" in result.reason


def test_two_apps_on_one_port_are_distinguished(server: LegacyServer) -> None:
    second: list[RunResult] = []
    first = drive(server.port, Once(lambda: second.append(drive(server.port))), duration_s=0.5)
    assert first.outcome is Outcome.SUCCESS
    assert "A port serves one program at a time" in second[0].reason


def test_simulation_whose_time_does_not_move_after_the_start_is_started_again(
    simulator: Simulator, server: LegacyServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts: list[float] = []
    started = simulator.start

    def start() -> None:
        starts.append(simulator.time)
        started()
        if len(starts) == 1:
            simulator.stepping.raise_level("nobody")

    monkeypatch.setattr(simulator, "start", start)
    result = drive(server.port, duration_s=0.3)
    assert result.outcome is Outcome.SUCCESS, result.reason
    assert len(starts) > 1


class Interrupting:
    """A server that takes its time over one answer, in which somebody presses Ctrl-C."""

    def __init__(self, server: LegacyServer) -> None:
        self._server = server

    def send(self, line: socket.socket, answer: bytes) -> None:
        self._server.service.fail(None)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        line.sendall(answer)


@pytest.mark.parametrize("stepped", [True, False])
def test_signal_between_a_question_and_its_answer_leaves_a_line_on_which_all_is_stopped(
    simulator: Simulator, server: LegacyServer, patient: str, *, stepped: bool
) -> None:
    result = drive(server.port, Once(lambda: server.service.fail(Interrupting(server))), robot=patient, stepped=stepped)
    left = simulator.graph.find("/rover/left_motor")
    assert isinstance(left, Joint)
    assert (result.outcome, result.reason) == (Outcome.INTERRUPTED, "interrupted by SIGINT")
    assert (left.target_velocity, simulator.state) == (0.0, State.STOPPED)


@pytest.mark.parametrize("stepped", ["true", "false"])
def test_killed_run_leaves_no_wheel_turning_for_the_simulation_goes_on(
    simulator: Simulator, server: LegacyServer, stepped: str
) -> None:
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

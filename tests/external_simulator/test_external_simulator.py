"""Runs on a simulator in another process that is killed or suspended during the run."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.external_simulator.backend import ExternalSimulatorBackend, register
from tests.robotcore.fakes import FunctionApp

ROOT = Path(__file__).parents[2]
NAMED = ("left_motor", "right_motor", "left_encoder", "right_encoder", "nose", "backend")


@pytest.fixture
def server() -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "tests.external_simulator.server"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


def port_of(server: subprocess.Popen[str]) -> str:
    assert server.stdout
    return server.stdout.readline().strip()


@pytest.fixture
def backend(monkeypatch: pytest.MonkeyPatch) -> ExternalSimulatorBackend:
    external = ExternalSimulatorBackend()
    monkeypatch.setattr("robotcore.runtime.plan.load_backend", lambda _: external)
    return external


def run_and_signal(server: subprocess.Popen[str], monkeypatch: pytest.MonkeyPatch, number: int) -> RunResult:
    """Run an app that drives, and send the server a signal in the fifth tick."""
    ticks: list[int] = []

    def drive(robot: Robot) -> Status:
        ticks.append(1)
        robot.drive.set_velocity(0.1, 0.0)
        if len(ticks) == 5:
            server.send_signal(number)
        return Status.RUNNING

    monkeypatch.setattr("robotcore.runtime.plan.load_app", type)
    monkeypatch.setattr("robotcore.runtime.plan.configure", lambda *_: FunctionApp(drive))
    return run(RunRequest("an_app", options={"port": port_of(server)}))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_lost_simulator_is_named_and_a_stop_is_sent_to_every_motor(
    server: subprocess.Popen[str],
    backend: ExternalSimulatorBackend,
    monkeypatch: pytest.MonkeyPatch,
    number: signal.Signals,
) -> None:
    result = run_and_signal(server, monkeypatch, number)
    server.kill()  # ends the calls that wait for an answer
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert any(name in result.reason.partition(";")[0] for name in NAMED)
    assert result.verified is None
    last = {request[1]: request[2] for request in backend.client.requests if request[0] == "turn"}
    assert last == {"left_motor": 0.0, "right_motor": 0.0}


@pytest.mark.slow
def test_registered_backend_has_the_trace_of_the_kinematic_simulator(
    server: subprocess.Popen[str], tmp_path: Path
) -> None:
    register(tmp_path)
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    run_it = [sys.executable, "-m", "robotcore", "run", "green-search", "--world", "open", "--timeout", "2", "--json"]
    digests = []
    for arguments in (["--backend", "external", "--port", port_of(server)], ["--backend", "kinematic"]):
        env = {**os.environ, "PYTHONPATH": path}
        answer = subprocess.run([*run_it, *arguments], env=env, capture_output=True, text=True, check=False)
        digests.append(json.loads(answer.stdout)["trace_sha256"])
    assert digests[0] == digests[1]

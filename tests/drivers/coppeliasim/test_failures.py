"""Tests of runs whose simulator fails. Each run ends soon with a specific error, and the next run works."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from types import MappingProxyType
from typing import Any

import pytest
import zmq

from drivers.coppeliasim import simulator_lock
from drivers.coppeliasim.address import Address, build_error
from drivers.coppeliasim.connection import SimulatorConnection
from drivers.coppeliasim.cutoff import StopJoints
from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator, State
from tests.doubles.coppeliasim.scene.objects import Joint, ProximitySensor
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene
from tests.robotcore.runs import CallOnce
from tests.texts import CheckText

BOUND_S = 6.0
"""The time after which a run counts as hanging, in seconds.

On an idle machine, errors are raised within two seconds.
"""

NONE: Mapping[str, Any] = MappingProxyType({})


@pytest.fixture(autouse=True)
def _short_lock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulator_lock, "DEAD_S", 0.5)


@pytest.fixture
def simulator() -> Simulator:
    return default_scene()


@pytest.fixture
def double(simulator: Simulator) -> Iterator[Double]:
    with Double(simulator) as double:
        yield double


def drive(
    port: int, *observers: CallOnce, duration_s: float = 60.0, robot: str = "rover", options: Mapping[str, Any] = NONE
) -> RunResult:
    clock = MonotonicClock()
    settings, options = {"duration_s": duration_s}, {"port": port, **options}
    result = run(RunRequest("avoid-obstacles", "coppeliasim", robot, settings=settings, options=options), observers)
    assert clock.now() < BOUND_S
    return result


def require_error(result: RunResult, kind: str) -> None:
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, BackendError)
    assert result.error.kind == kind
    assert result.reason.count("coppeliasim:") == 1, f"reported more than once: {result.reason}"


@pytest.mark.slow
def test_server_that_ends_in_a_run_ends_it_and_the_next_run_works() -> None:
    with Double(default_scene()) as dying:
        port = dying.zmq_port
        require_error(drive(port, CallOnce(lambda: dying.__exit__(None, None, None))), "server-gone")
    with Double(default_scene(), zmq_port=port):
        assert drive(port, duration_s=0.3).outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_server_that_hangs_in_a_run_ends_it_and_the_next_run_restores_the_scene(
    simulator: Simulator, double: Double
) -> None:
    require_error(drive_until_it_hangs(double), "timeout")
    wait_until_wheels_stop(simulator)
    assert drive(double.zmq_port, duration_s=0.3).outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_wheels_stop_once_a_server_that_hung_answers() -> None:
    simulator = bubblerob_with_described_range()
    with Double(simulator) as double:
        result = drive_until_it_hangs(double, robot="bubblerob", options={"answer_s": 0.3})
        assert isinstance(result.error, BackendError)
        assert result.error.kind == "timeout"
        wait_until_wheels_stop(simulator)


def test_scene_is_closed_although_no_stop_can_be_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise zmq.Again

    with Double(bubblerob_scene()) as double:
        connection = SimulatorConnection.open(Address(port=double.zmq_port), 1.0)
        scene = CoppeliaSimScene(connection)
        for joint in double.simulator.graph.all_of(Joint):
            scene.set_joint_velocity(joint.handle, 0.0)
        connection.fail(build_error(connection.address, "timeout", "no answer"))
        monkeypatch.setattr("drivers.coppeliasim.client.RemoteAPIClient._send", fail)
        scene.close()
    assert connection._client.socket.closed


def test_guardian_reports_that_the_server_has_ended(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    monkeypatch.setattr("drivers.coppeliasim.client.is_listening", lambda _: False)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        check_text(StopJoints("127.0.0.1", port, [1]).stop(), hide=[port])


def drive_until_it_hangs(double: Double, **request: Any) -> RunResult:
    """Drive until the simulator hangs and the run has ended. Then let the simulator continue."""
    is_over = threading.Event()

    def hang() -> None:
        with double.simulator.lock:
            is_over.wait(BOUND_S)

    hanging = threading.Thread(target=hang)
    result = drive(double.zmq_port, CallOnce(hanging.start), **request)
    assert any(joint.target_velocity for joint in double.simulator.graph.all_of(Joint))
    is_over.set()
    hanging.join()
    return result


@pytest.mark.slow
@pytest.mark.parametrize(
    "halt, kind",
    [(Simulator.stop, "simulation-stopped"), (Simulator.pause, "simulation-paused")],
    ids=["stopped", "paused"],
)
def test_simulation_that_the_user_halts_ends_the_run(
    simulator: Simulator,
    double: Double,
    halt: Callable[[Simulator], None],
    kind: str,
    check_text: CheckText,
) -> None:
    def halt_locked() -> None:
        with simulator.lock:
            halt(simulator)

    result = drive(double.zmq_port, CallOnce(halt_locked))
    require_error(result, kind)
    check_text(result.reason, hide=[double.zmq_port])


@pytest.mark.slow
def test_simulator_that_drops_its_client_ends_the_run(simulator: Simulator, double: Double) -> None:
    def drop_clients() -> None:
        with simulator.lock:
            for client in list(double._zmq._clients):
                double._zmq._drop(client)
            before = simulator.time
            assert simulator.changed.wait_for(lambda: simulator.time > before + 0.1, BOUND_S)

    require_error(drive(double.zmq_port, CallOnce(drop_clients)), "lockstep-lost")


@pytest.mark.slow
def test_second_program_is_refused_and_the_first_continues(
    double: Double, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr(simulator_lock, "RENEWAL_S", 0.1)
    second: list[RunResult] = []
    first = drive(double.zmq_port, CallOnce(lambda: second.append(drive(double.zmq_port))), duration_s=0.5)
    assert first.outcome is Outcome.SUCCESS, first.reason
    require_error(second[0], "lease-held")
    check_text(second[0].reason, hide=[double.zmq_port])


@pytest.mark.slow
def test_program_that_lost_the_lock_changes_nothing_more(
    simulator: Simulator, double: Double, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr(simulator_lock, "RENEWAL_S", 3600.0)
    last: list[list[str]] = []

    def take_over() -> None:
        with simulator.lock:
            double._zmq._shared.stored_values["named", simulator_lock.PARAMETER] = "another 7"
            simulator.pause()
        last.append(list_names(simulator))

    result = drive(double.zmq_port, CallOnce(take_over))
    require_error(result, "lease-lost")
    check_text(result.reason, hide=[double.zmq_port])
    assert list_names(simulator) == last[0]
    assert double._zmq._shared.stored_values["named", simulator_lock.PARAMETER] == "another 7"


def test_simulation_in_its_last_steps_counts_as_stopped() -> None:
    simulator = bubblerob_scene()
    with (
        Double(simulator) as double,
        closing(SimulatorConnection.open(Address(port=double.zmq_port), 1.0)) as connection,
    ):
        connection.sim("startSimulation")
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.time > 0, BOUND_S)
            simulator.stop()
            assert simulator.changed.wait_for(lambda: simulator.state is State.ABOUT_TO_STOP, BOUND_S)
        assert CoppeliaSimScene(connection).read_state().value == "stopped"


def bubblerob_with_described_range() -> Simulator:
    simulator = bubblerob_scene()
    nose = simulator.graph.find("/bubbleRob/sensingNose")
    assert isinstance(nose, ProximitySensor)
    nose.reach = 0.5
    return simulator


@pytest.mark.slow
@pytest.mark.parametrize(
    "robot, scene",
    [
        pytest.param("rover", default_scene, id="built"),
        pytest.param("bubblerob", bubblerob_with_described_range, id="joined"),
    ],
)
def test_killed_program_leaves_no_wheel_turning(robot: str, scene: Callable[[], Simulator]) -> None:
    simulator = scene()
    before = list_names(simulator)
    with Double(simulator) as double:
        command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", "--backend", "coppeliasim"]
        options = ["--robot", robot, "--port", str(double.zmq_port), "--set", "duration_s=600", "--realtime"]
        with subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as app:
            with simulator.lock:
                assert simulator.changed.wait_for(lambda: simulator.time > 0.2 and any(read_targets(simulator)), 30)
            app.send_signal(signal.SIGKILL)
        wait_until_wheels_stop(simulator)
        if robot == "rover":
            assert "left_motor" in list_names(simulator)
            assert drive(double.zmq_port, duration_s=0.3).outcome is Outcome.SUCCESS
            assert list_names(simulator) == before


def wait_until_wheels_stop(simulator: Simulator) -> None:
    clock = MonotonicClock()
    while any(read_targets(simulator)):
        assert clock.now() < BOUND_S
        clock.sleep_until(clock.now() + 0.02)


def read_targets(simulator: Simulator) -> list[float]:
    with simulator.lock:
        return [joint.target_velocity for joint in simulator.graph.all_of(Joint)]


def list_names(simulator: Simulator) -> list[str]:
    with simulator.lock:
        return [node.alias for node in simulator.graph]


@pytest.mark.slow
def test_signal_during_a_call_ends_the_run_and_restores_the_scene(
    simulator: Simulator, double: Double, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {node.handle for node in simulator.graph}
    advance = simulator.advance

    def advance_during_ctrl_c() -> None:
        monkeypatch.setattr(simulator, "advance", advance)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        advance()

    pressing = CallOnce(lambda: monkeypatch.setattr(simulator, "advance", advance_during_ctrl_c))
    result = drive(double.zmq_port, pressing)
    assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 128 + signal.SIGINT)
    assert {node.handle for node in simulator.graph} == before
    assert simulator.state is State.STOPPED

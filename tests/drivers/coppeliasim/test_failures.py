"""What becomes of a run whose simulator fails: an error by name, soon, and then all is well again."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from drivers.coppeliasim import lease
from drivers.coppeliasim.address import Address
from drivers.coppeliasim.connection import Connection
from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import Joint, ProximitySensor
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene
from tests.robotcore.runs import Once

BOUND_S = 6.0
"""Against a hang only: errors come within two seconds on a machine that is not busy."""


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lease, "DEAD_S", 0.5)


@pytest.fixture
def simulator() -> Simulator:
    return default_scene()


@pytest.fixture
def double(simulator: Simulator) -> Iterator[Double]:
    with Double(simulator) as double:
        yield double


def drive(port: int, *observers: Once, duration_s: float = 60.0) -> RunResult:
    clock = MonotonicClock()
    settings, options = {"duration_s": duration_s}, {"port": port}
    result = run(RunRequest("avoid-obstacles", "coppeliasim", settings=settings, options=options), observers)
    assert clock.now() < BOUND_S
    return result


def require_error(result: RunResult, named: str) -> None:
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert named in result.reason
    assert result.reason.count("coppeliasim:") == 1, f"told more than once: {result.reason}"


def test_server_that_dies_in_a_run_ends_it_by_name_and_the_next_run_works() -> None:
    with Double(default_scene()) as dying:
        port = dying.zmq_port
        require_error(
            drive(port, Once(lambda: dying.__exit__(None, None, None))), "is gone; it died or was closed in sim."
        )
    with Double(default_scene(), zmq_port=port):
        assert drive(port, duration_s=0.3).outcome is Outcome.SUCCESS


def test_server_that_hangs_in_a_run_ends_it_by_name_and_the_next_run_recovers_its_scene(
    simulator: Simulator, double: Double
) -> None:
    is_over = threading.Event()

    def hang() -> None:
        with simulator.lock:
            is_over.wait(BOUND_S)

    hanging = threading.Thread(target=hang)
    result = drive(double.zmq_port, Once(hanging.start))
    is_over.set()
    hanging.join()
    require_error(result, "has not answered sim.")
    assert drive(double.zmq_port, duration_s=0.3).outcome is Outcome.SUCCESS


@pytest.mark.parametrize(
    "deed, named",
    [(Simulator.stop, "was stopped by somebody else"), (Simulator.pause, "was paused by somebody else")],
    ids=["stopped", "paused"],
)
def test_simulation_that_somebody_halts_ends_the_run_by_name(
    simulator: Simulator, double: Double, deed: Callable[[Simulator], None], named: str
) -> None:
    def halt() -> None:
        with simulator.lock:
            deed(simulator)

    require_error(drive(double.zmq_port, Once(halt)), named)


def test_simulator_that_forgets_its_program_ends_the_run_for_time_goes_on(simulator: Simulator, double: Double) -> None:
    def forget() -> None:
        with simulator.lock:
            for client in list(double._zmq._clients):
                double._zmq._drop(client)
            before = simulator.time
            assert simulator.changed.wait_for(lambda: simulator.time > before + 0.1, BOUND_S)

    require_error(drive(double.zmq_port, Once(forget)), "it is no longer in lockstep")


def test_second_program_is_refused_and_the_first_goes_on(double: Double, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lease, "RENEWAL_S", 0.1)
    second: list[RunResult] = []
    first = drive(double.zmq_port, Once(lambda: second.append(drive(double.zmq_port))), duration_s=0.5)
    assert first.outcome is Outcome.SUCCESS, first.reason
    require_error(second[0], "another program drives the CoppeliaSim")


def test_program_that_was_silent_for_too_long_leaves_all_to_who_has_taken_over(
    simulator: Simulator, double: Double, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lease, "RENEWAL_S", 3600.0)
    last: list[list[str]] = []

    def take_over() -> None:
        with simulator.lock:
            double._zmq._shared.kept["named", lease.PARAMETER] = "another 7"
            simulator.pause()
        last.append(names(simulator))

    require_error(drive(double.zmq_port, Once(take_over)), "another one has taken over")
    assert names(simulator) == last[0]
    assert double._zmq._shared.kept["named", lease.PARAMETER] == "another 7"


def test_simulation_that_takes_its_last_steps_counts_as_stopped() -> None:
    simulator = bubblerob_scene()
    with Double(simulator) as double, closing(Connection.open(Address(port=double.zmq_port), 1.0)) as connection:
        connection.sim("startSimulation")
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.time > 0, BOUND_S)
            simulator.stop()
            assert simulator.changed.wait_for(lambda: simulator.state is State.ABOUT_TO_STOP, BOUND_S)
        assert CoppeliaSimScene(connection).read_state().value == "stopped"


def test_killed_program_leaves_a_scene_that_the_next_one_clears(simulator: Simulator, double: Double) -> None:
    before = names(simulator)
    command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", "--backend", "coppeliasim"]
    options = ["--port", str(double.zmq_port), "--set", "duration_s=600", "--realtime"]
    with subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as app:
        with simulator.lock:
            assert simulator.changed.wait_for(lambda: simulator.time > 0.2, 30)
        app.send_signal(signal.SIGKILL)
    assert simulator.state.is_advancing
    assert "left_motor" in names(simulator)
    assert drive(double.zmq_port, duration_s=0.3).outcome is Outcome.SUCCESS
    assert names(simulator) == before


def bubblerob_seeing_as_far_as_described() -> Simulator:
    simulator = bubblerob_scene()
    nose = simulator.graph.find("/bubbleRob/sensingNose")
    assert isinstance(nose, ProximitySensor)
    nose.reach = 0.5
    return simulator


@pytest.mark.parametrize(
    "robot, scene",
    [
        pytest.param("rover", default_scene, id="that was built"),
        pytest.param("bubblerob", bubblerob_seeing_as_far_as_described, id="that was joined"),
    ],
)
def test_killed_program_leaves_no_wheel_of_a_scene_turning(robot: str, scene: Callable[[], Simulator]) -> None:
    simulator = scene()
    with Double(simulator) as double:
        command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", "--backend", "coppeliasim"]
        options = ["--robot", robot, "--port", str(double.zmq_port), "--set", "duration_s=600", "--realtime"]
        with subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as app:
            with simulator.lock:
                assert simulator.changed.wait_for(lambda: simulator.time > 0.2 and any(targets(simulator)), 30)
            app.send_signal(signal.SIGKILL)
        clock = MonotonicClock()
        while any(targets(simulator)):
            assert clock.now() < BOUND_S
            clock.sleep_until(clock.now() + 0.02)


def targets(simulator: Simulator) -> list[float]:
    with simulator.lock:
        return [joint.target_velocity for joint in simulator.graph.all_of(Joint)]


def names(simulator: Simulator) -> list[str]:
    with simulator.lock:
        return [thing.alias for thing in simulator.graph]


def test_signal_in_the_middle_of_a_call_leaves_a_line_on_which_all_is_put_right(
    simulator: Simulator, double: Double, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {thing.handle for thing in simulator.graph}
    advance = simulator.advance

    def advance_while_somebody_presses_ctrl_c() -> None:
        monkeypatch.setattr(simulator, "advance", advance)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        advance()

    pressing = Once(lambda: monkeypatch.setattr(simulator, "advance", advance_while_somebody_presses_ctrl_c))
    result = drive(double.zmq_port, pressing)
    assert (result.outcome, result.reason) == (Outcome.INTERRUPTED, "interrupted by SIGINT")
    assert {thing.handle for thing in simulator.graph} == before
    assert simulator.state is State.STOPPED

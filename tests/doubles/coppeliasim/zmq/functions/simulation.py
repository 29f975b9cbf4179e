"""Starting, stopping and stepping, and the time."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session, Waiting


@function("startSimulation")
def start_simulation(session: Session) -> None:
    session.simulator.start()


@function("pauseSimulation")
def pause_simulation(session: Session) -> None:
    session.simulator.pause()


@function("stopSimulation")
def stop_simulation(session: Session, wait: bool = False) -> None:  # noqa: FBT002
    session.simulator.stop()
    if wait:
        raise Waiting(None)


@function("getSimulationState")
def get_simulation_state(session: Session) -> int:
    return int(session.simulator.state)


@function("getSimulationTime")
def get_simulation_time(session: Session) -> float:
    return session.simulator.time


@function("getSimulationTimeStep")
def get_simulation_time_step(session: Session) -> float:
    return session.simulator.time_step


@function("setStepping")
def set_stepping(session: Session, is_on: bool = True) -> int:  # noqa: FBT002
    """Return the level before."""
    simulator = session.simulator
    return simulator.hold(session.client) if is_on else simulator.let_go(session.client)


@function("step")
def step(session: Session, wait: bool = True) -> None:  # noqa: FBT002
    if not session.client:
        raise SceneError("a script of the double cannot wait for a step.")
    raise Waiting(session.simulator.step(session.client))

"""The functions about the simulation, scripts, signals and custom data."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Node, NoObjectError, Script
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import fill_default_scene
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import PendingReply, Session


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
        raise PendingReply(None)


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
    """Raise or lower the client's stepping level, and return the previous one."""
    simulator = session.simulator
    return simulator.hold(session.client) if is_on else simulator.release(session.client)


@function("step")
def step(session: Session, wait: bool = True) -> None:  # noqa: FBT002
    if not session.client:
        raise SceneError("a script of the double cannot wait for a step.")
    raise PendingReply(session.simulator.step(session.client))


DEFAULT_SCENES = ("scene.ttt", "dfltscn.ttt", "")
"""The names of the default scene: its recorded file, the simulator's own file, and an empty name."""


@function("loadScene")
def load_scene(session: Session, path: str) -> int:
    if session.simulator.state is not State.STOPPED:
        raise SceneError("simulation is not stopped.")
    if path not in DEFAULT_SCENES:
        raise SceneError(f"the double reads no scene files; it has the default scene as {DEFAULT_SCENES[0]}.")
    fill_default_scene(session.simulator)
    return 1


@function("closeScene")
def close_scene(session: Session) -> int:
    return load_scene(session, "")


@function("createScript")
def create_script(session: Session, kind: int, text: str, options: int = 0, language: str = "lua") -> int:
    return session.simulator.graph.add(Script("script", text=text)).handle


@function("initScript")
def init_script(session: Session, script: Script) -> None:
    session.shared.scripts.begin(script)


@function("callScriptFunction")
def call_script_function(session: Session, name: str, handle: int, *args: Any) -> tuple[Any, ...]:
    script = session.simulator.graph.get(handle)
    if not isinstance(script, Script):
        raise NoObjectError("script does not exist.")
    return session.shared.scripts.call(script, name, args)


@function("setStringSignal")
def set_string_signal(session: Session, name: str, value: Any) -> int:
    session.shared.signals[name] = value
    return 1


@function("getStringSignal")
def get_string_signal(session: Session, name: str) -> Any:
    return session.shared.signals.get(name)


@function("setInt32Signal")
def set_int32_signal(session: Session, name: str, value: int) -> int:
    session.shared.signals[name] = value
    return 1


@function("getInt32Signal")
def get_int32_signal(session: Session, name: str) -> Any:
    return session.shared.signals.get(name)


@function("setFloatSignal")
def set_float_signal(session: Session, name: str, value: float) -> int:
    session.shared.signals[name] = value
    return 1


@function("getFloatSignal")
def get_float_signal(session: Session, name: str) -> Any:
    return session.shared.signals.get(name)


@function("writeCustomStringData")
def write_custom_string_data(session: Session, node: Node, tag: str, data: str) -> int:
    session.shared.stored_values[node, "data", tag] = data
    return 1


@function("readCustomStringData")
def read_custom_string_data(session: Session, node: Node, tag: str) -> Any:
    return session.shared.stored_values.get((node, "data", tag))


@function("setNamedStringParam")
def set_named_string_param(session: Session, name: str, value: str) -> int:
    session.shared.stored_values["named", name] = value
    return 1


@function("getNamedStringParam")
def get_named_string_param(session: Session, name: str) -> bytes | None:
    value = session.shared.stored_values.get(("named", name))
    return None if value is None else value.encode()

"""Parameters of the simulator, by number: those that have an effect here, and those that are kept."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

TIME_STEP, PHYSICS_STEP, DYNAMIC_STEP = 1, 5, 3
ENGINE, FULL_VERSION, REAL_TIME = 8, 39, 25
GRAVITY, AMBIENT = 0, 5

INTS = {ENGINE: 0, FULL_VERSION: 4100000}
BOOLS = {REAL_TIME: False}
ARRAYS = {GRAVITY: [0.0, 0.0, -9.8100004196167], AMBIENT: [0.4000000059604645] * 3}
"""What a real server tells before anybody has set it; no others are known."""


@function("getFloatParam")
def get_float_param(session: Session, number: int) -> float:
    simulator = session.simulator
    if number == TIME_STEP:
        return simulator.time_step
    if number in {PHYSICS_STEP, DYNAMIC_STEP}:
        return simulator.physics_step
    raise _lacking("float", number)


@function("setFloatParam")
def set_float_param(session: Session, number: int, value: float) -> int:
    """Return 1; 0 where it cannot be set now: steps only while stopped."""
    if number == TIME_STEP:
        return int(session.simulator.set_time_step(value))
    if number in {PHYSICS_STEP, DYNAMIC_STEP}:
        return int(session.simulator.set_physics_step(value))
    raise _lacking("float", number)


@function("getInt32Param")
def get_int32_param(session: Session, number: int) -> int:
    return int(_kept(session, "int", number, INTS))


@function("setInt32Param")
def set_int32_param(session: Session, number: int, value: int) -> int:
    return _keep(session, "int", number, value, INTS)


@function("getBoolParam")
def get_bool_param(session: Session, number: int) -> bool:
    return bool(_kept(session, "bool", number, BOOLS))


@function("setBoolParam")
def set_bool_param(session: Session, number: int, value: bool) -> int:
    return _keep(session, "bool", number, bool(value), BOOLS)


@function("getArrayParam")
def get_array_param(session: Session, number: int) -> list[float]:
    return list(_kept(session, "array", number, ARRAYS))


@function("setArrayParam")
def set_array_param(session: Session, number: int, values: list) -> int:  # type: ignore[type-arg]
    numbers = [float(value) for value in values]
    if number == AMBIENT:
        look = session.simulator.look
        look.light = look.light.model_copy(update={"ambient": sum(numbers) / len(numbers)})
        session.simulator.graph.revision += 1
    return _keep(session, "array", number, numbers, ARRAYS)


@function("getSystemTime")
def get_system_time(session: Session) -> float:
    return session.shared.clock.now()


@function("addLog")
def add_log(session: Session, level: int, text: str) -> None:
    """Nobody reads it."""


@function("setEngineFloatParam")
def set_engine_float_param(session: Session, number: int, handle: int, value: float) -> int:
    return _keep_engine(session, "float", number, handle, value)


@function("getEngineFloatParam")
def get_engine_float_param(session: Session, number: int, handle: int) -> float:
    return float(_kept_engine(session, "float", number, handle))


@function("setEngineInt32Param")
def set_engine_int32_param(session: Session, number: int, handle: int, value: int) -> int:
    return _keep_engine(session, "int", number, handle, value)


@function("getEngineInt32Param")
def get_engine_int32_param(session: Session, number: int, handle: int) -> int:
    return int(_kept_engine(session, "int", number, handle))


@function("setEngineBoolParam")
def set_engine_bool_param(session: Session, number: int, handle: int, value: bool) -> int:
    return _keep_engine(session, "bool", number, handle, bool(value))


@function("getEngineBoolParam")
def get_engine_bool_param(session: Session, number: int, handle: int) -> bool:
    return bool(_kept_engine(session, "bool", number, handle))


def _keep_engine(session: Session, kind: str, number: int, handle: int, value: Any) -> int:
    """Keep what an engine would use: nothing slips here. -1 is the engine itself."""
    if handle != -1:
        _ = session.simulator.graph[handle]
    session.shared.kept["engine", kind, number, handle] = value
    return 1


def _kept_engine(session: Session, kind: str, number: int, handle: int) -> Any:
    try:
        return session.shared.kept["engine", kind, number, handle]
    except KeyError:
        raise _lacking(f"engine {kind}", number) from None


def _kept(session: Session, kind: str, number: int, defaults: dict[int, Any]) -> Any:
    if number not in defaults:
        raise _lacking(kind, number)
    return session.shared.kept.get(("parameter", kind, number), defaults[number])


def _keep(session: Session, kind: str, number: int, value: Any, defaults: dict[int, Any]) -> int:
    if number not in defaults:
        raise _lacking(kind, number)
    session.shared.kept["parameter", kind, number] = value
    return 1


def _lacking(kind: str, number: int) -> SceneError:
    return SceneError(f"the double has no {kind} parameter {number}.")

"""Parameters of the simulator, by number: those that have an effect here, and those that are kept."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

TIME_STEP, PHYSICS_STEP, DYNAMIC_STEP = 1, 5, 3
VERSION, ENGINE, PLATFORM, REVISION, FULL_VERSION = 1, 8, 19, 30, 39
GRAVITY, BACKGROUND, OTHER_BACKGROUND, AMBIENT = 0, 3, 4, 5

INTS = {VERSION: 41000, ENGINE: 0, PLATFORM: 2, REVISION: 0, FULL_VERSION: 4100000}
BOOLS = {1: False, 6: True, 9: True, 10: True, 16: False, 25: False, 34: True}
ARRAYS = {GRAVITY: [0.0, 0.0, -9.81]}


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
    light = session.simulator.look.light
    if number in {BACKGROUND, OTHER_BACKGROUND}:
        return [part / 255 for part in light.sky_colour]
    if number == AMBIENT:
        return [light.ambient] * 3
    return list(_kept(session, "array", number, ARRAYS))


@function("setArrayParam")
def set_array_param(session: Session, number: int, values: list) -> int:  # type: ignore[type-arg]
    numbers = [float(value) for value in values]
    look = session.simulator.look
    if number in {BACKGROUND, OTHER_BACKGROUND}:
        look.light = look.light.model_copy(update={"sky_colour": tuple(round(255 * part) for part in numbers)})
    elif number == AMBIENT:
        look.light = look.light.model_copy(update={"ambient": sum(numbers) / 3})
    else:
        return _keep(session, "array", number, numbers, ARRAYS)
    session.simulator.graph.revision += 1
    return 1


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

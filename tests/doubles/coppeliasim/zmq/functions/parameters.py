"""Parameters of the simulator and of objects, by number. Some have an effect; others are only stored."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Joint, ProximitySensor, Shape, Thing, VisionSensor
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

TIME_STEP, PHYSICS_STEP, DYNAMIC_STEP = 1, 5, 3
ENGINE, FULL_VERSION, REAL_TIME = 8, 39, 25
GRAVITY, AMBIENT = 0, 5

INTS = {ENGINE: 0, FULL_VERSION: 4100000}
BOOLS = {REAL_TIME: False}
ARRAYS = {GRAVITY: [0.0, 0.0, -9.8100004196167], AMBIENT: [0.4000000059604645] * 3}
"""The initial values on a real server; there are no other parameters."""


@function("getFloatParam")
def get_float_param(session: Session, number: int) -> float:
    simulator = session.simulator
    if number == TIME_STEP:
        return simulator.time_step
    if number in {PHYSICS_STEP, DYNAMIC_STEP}:
        return simulator.physics_step
    raise _missing_parameter("float", number)


@function("setFloatParam")
def set_float_param(session: Session, number: int, value: float) -> int:
    """Return 1, or 0 if the parameter cannot be set now: time steps can be set only while stopped."""
    if number == TIME_STEP:
        return int(session.simulator.set_time_step(value))
    if number in {PHYSICS_STEP, DYNAMIC_STEP}:
        return int(session.simulator.set_physics_step(value))
    raise _missing_parameter("float", number)


@function("getInt32Param")
def get_int32_param(session: Session, number: int) -> int:
    return int(_read_stored(session, "int", number, INTS))


@function("setInt32Param")
def set_int32_param(session: Session, number: int, value: int) -> int:
    return _store(session, "int", number, value, INTS)


@function("getBoolParam")
def get_bool_param(session: Session, number: int) -> bool:
    return bool(_read_stored(session, "bool", number, BOOLS))


@function("setBoolParam")
def set_bool_param(session: Session, number: int, value: bool) -> int:
    return _store(session, "bool", number, bool(value), BOOLS)


@function("getArrayParam")
def get_array_param(session: Session, number: int) -> list[float]:
    return list(_read_stored(session, "array", number, ARRAYS))


@function("setArrayParam")
def set_array_param(session: Session, number: int, values: list) -> int:  # type: ignore[type-arg]
    numbers = [float(value) for value in values]
    if number == AMBIENT:
        look = session.simulator.look
        look.light = look.light.model_copy(update={"ambient": sum(numbers) / len(numbers)})
        session.simulator.graph.revision += 1
    return _store(session, "array", number, numbers, ARRAYS)


@function("getSystemTime")
def get_system_time(session: Session) -> float:
    return session.shared.clock.now()


@function("addLog")
def add_log(session: Session, level: int, text: str) -> None:
    """Ignore the text."""


@function("setEngineFloatParam")
def set_engine_float_param(session: Session, number: int, handle: int, value: float) -> int:
    return _store_engine(session, "float", number, handle, value)


@function("getEngineFloatParam")
def get_engine_float_param(session: Session, number: int, handle: int) -> float:
    return float(_read_engine(session, "float", number, handle))


@function("setEngineInt32Param")
def set_engine_int32_param(session: Session, number: int, handle: int, value: int) -> int:
    return _store_engine(session, "int", number, handle, value)


@function("getEngineInt32Param")
def get_engine_int32_param(session: Session, number: int, handle: int) -> int:
    return int(_read_engine(session, "int", number, handle))


@function("setEngineBoolParam")
def set_engine_bool_param(session: Session, number: int, handle: int, value: bool) -> int:
    return _store_engine(session, "bool", number, handle, bool(value))


@function("getEngineBoolParam")
def get_engine_bool_param(session: Session, number: int, handle: int) -> bool:
    return bool(_read_engine(session, "bool", number, handle))


def _store_engine(session: Session, kind: str, number: int, handle: int, value: Any) -> int:
    """Store a parameter of the engine, without effect. -1 is the engine itself."""
    if handle != -1:
        _ = session.simulator.graph[handle]
    session.shared.kept["engine", kind, number, handle] = value
    return 1


def _read_engine(session: Session, kind: str, number: int, handle: int) -> Any:
    try:
        return session.shared.kept["engine", kind, number, handle]
    except KeyError:
        raise _missing_parameter(f"engine {kind}", number) from None


def _read_stored(session: Session, kind: str, number: int, defaults: dict[int, Any]) -> Any:
    if number not in defaults:
        raise _missing_parameter(kind, number)
    return session.shared.kept.get(("parameter", kind, number), defaults[number])


def _store(session: Session, kind: str, number: int, value: Any, defaults: dict[int, Any]) -> int:
    if number not in defaults:
        raise _missing_parameter(kind, number)
    session.shared.kept["parameter", kind, number] = value
    return 1


def _missing_parameter(kind: str, number: int) -> SceneError:
    return SceneError(f"the double has no {kind} parameter {number}.")


Numbered = dict[tuple[type[Thing], int], tuple[str, Callable[[Any], Any]]]

OBJECT_INTS: Numbered = {
    (Joint, 2039): ("control", int),
    (ProximitySensor, 4002): ("entity", int),
    (Shape, 3003): ("is_static", bool),
    (Shape, 3004): ("is_respondable", bool),
    (Shape, 3019): ("mask", int),
    (VisionSensor, 1002): ("width", int),
    (VisionSensor, 1003): ("height", int),
    (VisionSensor, 1008): ("entity", int),
    (VisionSensor, 1018): ("is_perspective", bool),
}
OBJECT_FLOATS: Numbered = {
    (Joint, 2012): ("velocity", float),
    (Shape, 3005): ("mass", float),
    (VisionSensor, 1000): ("near", float),
    (VisionSensor, 1001): ("far", float),
    (VisionSensor, 1004): ("angle", float),
}
VELOCITY_CONTROL = 4
NOT_MODEL, SPECIAL, SELECTABLE = 0xF000, 1011, 32
"""The properties of a new shape."""

MOTOR_ENABLED, CONTROL_ENABLED = 2000, 2001
"""Before 4.4, velocity control was the motor on and the position loop off."""


@function("setObjectInt32Param")
def set_object_int32_param(session: Session, thing: Thing, number: int, value: int) -> int:
    return _set(session, thing, number, value, OBJECT_INTS)


@function("getObjectInt32Param")
def get_object_int32_param(session: Session, thing: Thing, number: int) -> int:
    return int(_get(thing, number, OBJECT_INTS))


@function("setObjectFloatParam")
def set_object_float_param(session: Session, thing: Thing, number: int, value: float) -> int:
    return _set(session, thing, number, value, OBJECT_FLOATS)


@function("getObjectFloatParam")
def get_object_float_param(session: Session, thing: Thing, number: int) -> float:
    return float(_get(thing, number, OBJECT_FLOATS))


@function("getObjectSpecialProperty")
def get_object_special_property(session: Session, thing: Thing) -> int:
    return _read_property(session, thing, "special", SPECIAL)


@function("setObjectSpecialProperty")
def set_object_special_property(session: Session, thing: Thing, bits: int) -> int:
    session.shared.kept[thing, "special"] = bits
    return 1


@function("getObjectProperty")
def get_object_property(session: Session, thing: Thing) -> int:
    return _read_property(session, thing, "property", SELECTABLE)


@function("setObjectProperty")
def set_object_property(session: Session, thing: Thing, bits: int) -> int:
    session.shared.kept[thing, "property"] = bits
    return 1


@function("getModelProperty")
def get_model_property(session: Session, thing: Thing) -> int:
    return 0 if thing.is_model_base else NOT_MODEL


@function("setModelProperty")
def set_model_property(session: Session, thing: Thing, bits: int) -> int:
    thing.is_model_base = bits & NOT_MODEL == 0
    return 1


def _read_property(session: Session, thing: Thing, name: str, of_shapes: int) -> int:
    """Return the stored value; only shapes have a default."""
    if isinstance(thing, Shape) or (thing, name) in session.shared.kept:
        return int(session.shared.kept.get((thing, name), of_shapes))
    raise SceneError(f"the double knows the {name} bits of {thing.alias} only where they were set.")


def _set(session: Session, thing: Thing, number: int, value: float, known: Numbered) -> int:
    if (type(thing), number) in known:
        attribute, kind = known[type(thing), number]
        setattr(thing, attribute, kind(value))
        session.simulator.graph.revision += 1
    elif isinstance(thing, Joint) and number in {MOTOR_ENABLED, CONTROL_ENABLED}:
        thing.control = VELOCITY_CONTROL if number == MOTOR_ENABLED and value else thing.control
        session.simulator.graph.revision += 1
    thing.parameters[number] = value
    return 1


def _get(thing: Thing, number: int, known: Numbered) -> float:
    if (type(thing), number) in known:
        return float(getattr(thing, known[type(thing), number][0]))
    if number not in thing.parameters:
        raise SceneError(f"the double knows parameter {number} of {thing.alias} only where it was set.")
    return thing.parameters[number]

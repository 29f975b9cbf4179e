"""The functions about parameters of the simulator and of objects.

Some parameters have an effect; others are only stored.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Joint, Node, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

TIME_STEP, PHYSICS_STEP, DYNAMIC_STEP = 1, 5, 3
ENGINE, FULL_VERSION, REAL_TIME = 8, 39, 25
GRAVITY, AMBIENT = 0, 5

INTS = {ENGINE: 0, FULL_VERSION: 4100000}
BOOLS = {REAL_TIME: False}
ARRAYS = {GRAVITY: [0.0, 0.0, -9.8100004196167], AMBIENT: [0.4000000059604645] * 3}
"""The initial values of the array parameters on a real server. There are no other array parameters."""


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
    """Set a parameter, and return 1. Return 0 for a time step, unless the simulation is stopped."""
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
    """Store a parameter of the physics engine, which has no effect. The handle -1 is the engine itself."""
    if handle != -1:
        _ = session.simulator.graph[handle]
    session.shared.stored_values["engine", kind, number, handle] = value
    return 1


def _read_engine(session: Session, kind: str, number: int, handle: int) -> Any:
    try:
        return session.shared.stored_values["engine", kind, number, handle]
    except KeyError:
        raise _missing_parameter(f"engine {kind}", number) from None


def _read_stored(session: Session, kind: str, number: int, defaults: dict[int, Any]) -> Any:
    if number not in defaults:
        raise _missing_parameter(kind, number)
    return session.shared.stored_values.get(("parameter", kind, number), defaults[number])


def _store(session: Session, kind: str, number: int, value: Any, defaults: dict[int, Any]) -> int:
    if number not in defaults:
        raise _missing_parameter(kind, number)
    session.shared.stored_values["parameter", kind, number] = value
    return 1


def _missing_parameter(kind: str, number: int) -> SceneError:
    return SceneError(f"the double has no {kind} parameter {number}.")


Numbered = dict[tuple[type[Node], int], tuple[str, Callable[[Any], Any]]]

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
"""The model property, the special property and the property of a new shape."""

MOTOR_ENABLED, CONTROL_ENABLED = 2000, 2001
"""The numbers of two parameters.

Before CoppeliaSim 4.4, velocity control was: motor enabled, position control disabled.
"""


@function("setObjectInt32Param")
def set_object_int32_param(session: Session, node: Node, number: int, value: int) -> int:
    return _set(session, node, number, value, OBJECT_INTS)


@function("getObjectInt32Param")
def get_object_int32_param(session: Session, node: Node, number: int) -> int:
    return int(_get(node, number, OBJECT_INTS))


@function("setObjectFloatParam")
def set_object_float_param(session: Session, node: Node, number: int, value: float) -> int:
    return _set(session, node, number, value, OBJECT_FLOATS)


@function("getObjectFloatParam")
def get_object_float_param(session: Session, node: Node, number: int) -> float:
    return float(_get(node, number, OBJECT_FLOATS))


@function("getObjectSpecialProperty")
def get_object_special_property(session: Session, node: Node) -> int:
    return _read_property(session, node, "special", SPECIAL)


@function("setObjectSpecialProperty")
def set_object_special_property(session: Session, node: Node, bits: int) -> int:
    session.shared.stored_values[node, "special"] = bits
    return 1


@function("getObjectProperty")
def get_object_property(session: Session, node: Node) -> int:
    return _read_property(session, node, "property", SELECTABLE)


@function("setObjectProperty")
def set_object_property(session: Session, node: Node, bits: int) -> int:
    session.shared.stored_values[node, "property"] = bits
    return 1


@function("getModelProperty")
def get_model_property(session: Session, node: Node) -> int:
    return 0 if node.is_model_base else NOT_MODEL


@function("setModelProperty")
def set_model_property(session: Session, node: Node, bits: int) -> int:
    node.is_model_base = bits & NOT_MODEL == 0
    return 1


def _read_property(session: Session, node: Node, name: str, of_shapes: int) -> int:
    if isinstance(node, Shape) or (node, name) in session.shared.stored_values:
        return int(session.shared.stored_values.get((node, name), of_shapes))
    raise SceneError(f"the double has no {name} bits of {node.alias}, because they were not set.")


def _set(session: Session, node: Node, number: int, value: float, known: Numbered) -> int:
    if (type(node), number) in known:
        attribute, kind = known[type(node), number]
        setattr(node, attribute, kind(value))
        session.simulator.graph.revision += 1
    elif isinstance(node, Joint) and number in {MOTOR_ENABLED, CONTROL_ENABLED}:
        node.control = VELOCITY_CONTROL if number == MOTOR_ENABLED and value else node.control
        session.simulator.graph.revision += 1
    node.parameters[number] = value
    return 1


def _get(node: Node, number: int, known: Numbered) -> float:
    if (type(node), number) in known:
        return float(getattr(node, known[type(node), number][0]))
    if number not in node.parameters:
        raise SceneError(f"the double has no value of parameter {number} of {node.alias}, because it was not set.")
    return node.parameters[number]

"""Parameters and properties of objects, by number: those that have an effect here, and those that are kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Joint, ProximitySensor, Shape, Thing, VisionSensor
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

Numbered = dict[tuple[type[Thing], int], tuple[str, Callable[[Any], Any]]]

INTS: Numbered = {
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
FLOATS: Numbered = {
    (Joint, 2012): ("velocity", float),
    (Shape, 3005): ("mass", float),
    (VisionSensor, 1000): ("near", float),
    (VisionSensor, 1001): ("far", float),
    (VisionSensor, 1004): ("angle", float),
}
VELOCITY_CONTROL = 4
NOT_MODEL, SPECIAL, SELECTABLE = 0xF000, 1011, 32
"""Properties of a new shape."""

MOTOR_ENABLED, CONTROL_ENABLED = 2000, 2001
"""Until 4.3 a joint was driven by its velocity with the motor on and the position loop off."""


@function("setObjectInt32Param")
def set_object_int32_param(session: Session, thing: Thing, number: int, value: int) -> int:
    return _set(session, thing, number, value, INTS)


@function("getObjectInt32Param")
def get_object_int32_param(session: Session, thing: Thing, number: int) -> int:
    return int(_get(thing, number, INTS))


@function("setObjectFloatParam")
def set_object_float_param(session: Session, thing: Thing, number: int, value: float) -> int:
    return _set(session, thing, number, value, FLOATS)


@function("getObjectFloatParam")
def get_object_float_param(session: Session, thing: Thing, number: int) -> float:
    return float(_get(thing, number, FLOATS))


@function("getObjectSpecialProperty")
def get_object_special_property(session: Session, thing: Thing) -> int:
    return _known(session, thing, "special", SPECIAL)


@function("setObjectSpecialProperty")
def set_object_special_property(session: Session, thing: Thing, bits: int) -> int:
    session.shared.kept[thing, "special"] = bits
    return 1


@function("getObjectProperty")
def get_object_property(session: Session, thing: Thing) -> int:
    return _known(session, thing, "property", SELECTABLE)


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


def _known(session: Session, thing: Thing, name: str, of_shapes: int) -> int:
    """Return what was set; of others than shapes no more is known."""
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

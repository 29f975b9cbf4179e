"""The JSON schemas of a recording's messages, built from the classes of the events.

A message leaves out empty fields, and has NaN and infinite numbers as strings.
"""

from __future__ import annotations

from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from robotcore.hal.devices import Angle, Range, Voltage
from robotcore.recording.codec import list_fields
from robotcore.recording.events import GroundTruthSample, Tick

Schema = dict[str, Any]

_TYPES = {float: "number", int: "integer", str: "string"}


def build_schema(kind: Any) -> Schema:
    """Return the schema of a type. Fields of an optional type have the schema of the type without None."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return build_schema(arguments[0])
    if NoneType in arguments:
        return build_schema(next(each for each in arguments if each is not NoneType))
    if origin is tuple:
        return {"type": "array", "items": build_schema(arguments[0])}
    if kind in _TYPES:
        return {"type": _TYPES[kind]}
    names = list_fields(kind)
    hints = get_type_hints(kind, include_extras=True) if names else {}
    return {"type": "object", "properties": {name: build_schema(hints[name]) for name in names}}


def _name_schema(title: str, kind: Any = None, **properties: Any) -> Schema:
    """Return the schema of a class, or of an object with ``properties``, under a title."""
    named = {name: build_schema(each) for name, each in properties.items()}
    schema = {"type": "object", "properties": named} if kind is None else build_schema(kind)
    return {"title": f"robotcore.{title}", **schema}


TICK_SCHEMA = _name_schema("Tick", Tick)
RANGE_SCHEMA = _name_schema("Range", Range)
ANGLE_SCHEMA = _name_schema("Angle", Angle)
VOLTAGE_SCHEMA = _name_schema("Voltage", Voltage)
TRUTH_SCHEMA = _name_schema("Truth", GroundTruthSample)
RUN_SCHEMA = _name_schema("Run", request=dict, devices=tuple[str, ...], started=str)
RESULT_SCHEMA = _name_schema("Result", outcome=str, reason=str, exit_status=int, ticks=int)
END_SCHEMA = _name_schema("End", reason=str)

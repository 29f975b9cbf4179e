"""The JSON schemas of a recording's messages.

A message leaves out empty fields, and has NaN and infinite numbers as strings.
"""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]

_NUMBER: Schema = {"type": "number"}
_WHOLE: Schema = {"type": "integer"}
_TEXT: Schema = {"type": "string"}


def _object(title: str = "", **properties: Schema) -> Schema:
    named = {"title": f"robotcore.{title}"} if title else {}
    return {**named, "type": "object", "properties": properties}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


_WHEELS = _object(left=_NUMBER, right=_NUMBER)
_POSE = _object(x=_NUMBER, y=_NUMBER, heading=_NUMBER)
_ERROR = _object(kind=_TEXT, message=_TEXT, attributes=_object())
_READ = _object(device=_TEXT, sequence=_WHOLE, time=_NUMBER, number=_WHOLE, error=_ERROR, by=_TEXT)
_INTERVENTION = _object(time=_NUMBER, cause=_TEXT, asked=_WHEELS, sent=_WHEELS)

TICK_SCHEMA = _object(
    "Tick",
    number=_WHOLE,
    time=_NUMBER,
    state=_TEXT,
    reads=_list(_READ),
    asks=_list(_object(asked=_WHEELS, given=_WHEELS, error=_ERROR)),
    motor_asks=_list(_object(device=_TEXT, asked=_NUMBER, given=_NUMBER, error=_ERROR)),
    turned=_list(_object(angles=_WHEELS, error=_ERROR)),
    standing=_list(_WHEELS),
    pose=_POSE,
    asked=_WHEELS,
    sent=_WHEELS,
    interventions=_list(_INTERVENTION),
    commit_error=_ERROR,
    shown=_list(_object(device=_TEXT, number=_WHOLE, error=_ERROR)),
    error=_ERROR,
    warnings=_list(_TEXT),
)
RANGE_SCHEMA = _object("Range", distance=_NUMBER, time=_NUMBER, sequence=_WHOLE, point=_list(_NUMBER))
ANGLE_SCHEMA = _object("Angle", angle=_NUMBER, time=_NUMBER, sequence=_WHOLE)
VOLTAGE_SCHEMA = _object("Voltage", voltage=_NUMBER, time=_NUMBER, sequence=_WHOLE)
TRUTH_SCHEMA = _object("Truth", tick=_WHOLE, time=_NUMBER, pose=_POSE, contacts=_WHOLE)
RUN_SCHEMA = _object("Run", request=_object(), devices=_list(_TEXT), started=_TEXT)
RESULT_SCHEMA = _object("Result", outcome=_TEXT, reason=_TEXT, exit_status=_WHOLE, ticks=_WHOLE)
END_SCHEMA = _object("End", reason=_TEXT)

"""How a fault is written: its parameters with their units and limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robotcore.runtime.faults.fault import Fault

VALUE = "value"
"""The field that stands behind the effect itself."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a fault; ``limits`` are in words, empty where there are none."""

    name: str
    unit: str
    limits: str
    is_required: bool

    @property
    def form(self) -> str:
        """How it is written: ``after=SECONDS``, in brackets where it may be left out."""
        written = f"{self.name}={self.unit.upper().replace(' ', '_')}"
        return written if self.is_required else f"[{written}]"


def parameters_of(effect: str, fault: type[Fault]) -> list[Parameter]:
    """Return the parameters of a fault, its value first, by the name of the effect."""
    fields = fault.model_json_schema().get("properties", {})
    order = sorted(fields, key=lambda name: (name != VALUE, not fault.model_fields[name].is_required(), name))
    return [_parameter(effect if name == VALUE else name, fields[name], fault, name) for name in order]


def form_of(target: str, effect: str, fault: type[Fault]) -> str:
    """Return how a fault is written in full: ``camera drop=PROBABILITY [after=SECONDS] [lasts=SECONDS]``."""
    parameters = [parameter.form for parameter in parameters_of(effect, fault)]
    bare = [] if VALUE in fault.model_fields else [effect]
    return " ".join([target, *bare, *parameters])


def _parameter(name: str, schema: dict[str, Any], fault: type[Fault], field: str) -> Parameter:
    number = schema.get("anyOf", [schema])[0]
    unit = schema.get("description") or number.get("description") or VALUE
    return Parameter(name, unit, _limits(number), fault.model_fields[field].is_required())


def _limits(number: dict[str, Any]) -> str:
    bounds = {"from": "minimum", "above": "exclusiveMinimum", "to": "maximum", "below": "exclusiveMaximum"}
    return " ".join(f"{word} {number[key]:g}" for word, key in bounds.items() if key in number)

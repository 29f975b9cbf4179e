"""Samples as short texts with units, for prompts and messages."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from robotcore.hal.device import list_values
from robotcore.text import format_number

MAX_LISTED_VALUES = 8
"""The text of a tuple with more numbers has only their count, the least and the greatest of them."""


def format_fields(sample: Any) -> str:
    """Return the fields of a sample with their units as text, such as ``7.40 V`` or ``not pressed``.

    Each of several values, and a number without a unit, follows the name of its field.
    """
    kind: Any = type(sample)
    units = {value.field: value.unit for value in list_values(kind)}
    values = {each.name: getattr(sample, each.name) for each in fields(sample)}
    shown = {name: value for name, value in values.items() if name in units or isinstance(value, str)}
    if len(shown) == 1:
        ((name, value),) = shown.items()
        if units.get(name) or isinstance(value, tuple):
            return _format_value(value, units[name])
    return ", ".join(_format_field(name, value, units) for name, value in shown.items())


def _format_field(name: str, value: Any, units: Mapping[str, str]) -> str:
    words = name.replace("_", " ")
    if isinstance(value, bool):
        words = words.removeprefix("is ")
        return words if value else f"not {words}"
    return f"{words} {_format_value(value, units.get(name, ''))}"


def _format_value(value: Any, unit: str) -> str:
    return f"{_format_numbers(value)} {unit}".rstrip()


def _format_numbers(value: Any) -> str:
    if isinstance(value, str):
        return reprlib.repr(value)
    if not isinstance(value, (tuple, list)):
        return format_number(value)
    if len(value) <= MAX_LISTED_VALUES:
        return " ".join(map(format_number, value))
    return f"{len(value)} values from {format_number(min(value))} to {format_number(max(value))}"


def format_repr(sample: Any) -> str:
    """Return the class, the values and the time of a sample as text, such as ``Range 1.24 m at 3.15 s``."""
    return " ".join(filter(None, (type(sample).__name__, sample.format_values(), f"at {sample.time:.2f} s")))

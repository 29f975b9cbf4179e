"""Check that the values of a sample fit the types of its fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from robotcore.errors import DeviceError

NUMBERS: Mapping[Any, tuple[Any, str]] = {
    float: (Real, "a number"),
    int: (Integral, "a whole number"),
    bool: ((bool, np.bool_), "True or False"),
}
"""The classes of valid values of a number, and their description, by the number's type in a sample."""

_CLASSES: Mapping[Any, tuple[Any, str]] = {**NUMBERS, str: (str, "a text"), NoneType: (NoneType, "None")}


def describe_expected(expected: Any, value: Any) -> str:
    """Return what a value of a type must be, such as ``a whole number``; ``""`` if the value fits.

    A value of a type other than numbers, texts, optional values and tuples always fits.

    >>> describe_expected(tuple[float, ...], (0.5, "red"))
    'a tuple of which each value is a number'
    """
    origin, arguments = get_origin(expected), get_args(expected)
    if origin in (Union, UnionType):
        forms = [describe_expected(each, value) for each in arguments]
        return " or ".join(forms) if all(forms) else ""
    if origin is tuple:
        return _describe_tuple(arguments, value)
    classes, form = _CLASSES.get(expected, (object, ""))
    return "" if isinstance(value, classes) else form


def _describe_tuple(arguments: tuple[Any, ...], value: Any) -> str:
    if not isinstance(value, tuple):
        return "a tuple"
    types = arguments[:1] * len(value) if arguments[-1] is ... else arguments
    if len(types) != len(value):
        return f"a tuple of {len(types)} values"
    forms = (describe_expected(each, item) for each, item in zip(types, value, strict=True))
    return next((f"a tuple of which each value is {form}" for form in forms if form), "")


def require_types(device: str, sample: Any) -> None:
    """Raise DeviceError if a value of a sample does not fit the type of its field. This is too slow for each read."""
    for name, expected in _list_types(cast("Any", type(sample))).items():
        value = getattr(sample, name)
        if form := describe_expected(expected, value):
            text = f"a sample has {name} = {value!r}. It should be {form}. Correct the driver, or the kind's simulate"
            raise DeviceError(device, text, kind="sample-types")


def list_numbers(kind: Any) -> list[str]:
    """Return the names of the fields of a class that are numbers, flags, or tuples of them."""
    types = _list_types(kind)
    return [name for name, expected in types.items() if NUMBERS.keys() & {expected, *get_args(expected)}]


@cache
def _list_types(kind: Any) -> Mapping[str, Any]:
    if not is_dataclass(kind):
        return {}
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind)}

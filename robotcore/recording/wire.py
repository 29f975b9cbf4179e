"""Events as JSON: every double comes back as the very double it was; ``inf`` and ``nan``, too, which travel as strings.

What an event does not say (None, an empty tuple) is left out.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache, singledispatch
from numbers import Integral, Real
from typing import Any, TypeVar, cast

from pydantic import BaseModel, TypeAdapter

T = TypeVar("T")

_SURROGATE = re.compile(rb"\\u[dD][89a-fA-F]")


def to_json(event: Any) -> bytes:
    """Return an event as JSON. Python writes the shortest digits that read back as the same double."""
    return json.dumps(plain(event), allow_nan=False, separators=(",", ":")).encode()


def from_json(kind: type[T], content: bytes) -> T:
    """Return the event that `to_json` wrote; ValueError where it is none of this kind."""
    adapter: TypeAdapter[T] = _adapter(cast("Any", kind))
    return adapter.validate_python(parse_json(content))


def parse_json(content: bytes) -> Any:
    """Return what a JSON text holds; ValueError if a text in it has a lone surrogate, which no library can print."""
    payload = json.loads(content.decode())
    if _SURROGATE.search(content):
        json.dumps(payload, ensure_ascii=False).encode()
    return payload


@singledispatch
def plain(value: Any) -> Any:
    """Return a value in what JSON knows: the fields of an object or a named tuple by their names, else its words."""
    if is_dataclass(value):
        return _told({field.name: getattr(value, field.name) for field in fields(value)})
    return _words(str(value))


@plain.register(bool)
@plain.register(type(None))
def _itself(value: Any) -> Any:
    return value


@plain.register
def _words(value: str) -> str:
    """Return a text without its class, such as an app's own enumeration; a lone surrogate becomes an escape."""
    return str.encode(value, errors="backslashreplace").decode()


@plain.register
def _whole(value: Integral) -> int:
    return int(value)


@plain.register
def _number(value: Real) -> float | str:
    number = float(value)
    return number if math.isfinite(number) else repr(number)


@plain.register
def _named(value: Mapping) -> dict[str, Any]:  # type: ignore[type-arg]
    return {_words(str(key)): plain(each) for key, each in value.items()}


@plain.register
def _described(value: BaseModel) -> dict[str, Any]:
    return _named(value.model_dump())


@plain.register(tuple)
@plain.register(list)
@plain.register(frozenset)
def _many(value: Any) -> Any:
    return _told(value._asdict()) if hasattr(value, "_asdict") else [plain(each) for each in value]


def _told(named: Mapping[str, Any]) -> dict[str, Any]:
    return {name: plain(each) for name, each in named.items() if each is not None and each != ()}


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)

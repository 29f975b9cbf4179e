"""The values that an app logs in a tick: numbers, booleans and short texts under a name."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from robotcore.errors import UsageError

MAX_NAMES = 256
"""The greatest number of names in a run. Each becomes a channel of a recording and a column of a table."""

MAX_NAME_LENGTH, MAX_UNIT_LENGTH, MAX_TEXT_LENGTH = 64, 16, 200
"""The greatest lengths of a name, of a unit and of a logged text, in characters."""

MAX_INTEGER = 2**53
"""The greatest magnitude of a logged integer. Each smaller one is also a double."""

_NAME = re.compile(rf"[A-Za-z][A-Za-z0-9_-]{{0,{MAX_NAME_LENGTH - 1}}}")

Logged = float | int | bool | str
"""A value that an app can log."""


class LoggedValue(NamedTuple):
    """A value that an app logged, such as ``LoggedValue(0.31, "rad")``."""

    value: Logged
    unit: str = ""
    """The symbol of the unit, such as ``rad``; empty without a unit."""


NOTHING_LOGGED: Mapping[str, LoggedValue] = MappingProxyType({})
"""The values of a tick in which the app logged nothing."""


class ValueLog:
    """Collects the values that an app logs, until `take` returns those of the tick.

    A name has one value per tick, the last one. It keeps its unit and its type until the end of the run. The types are
    number, boolean and text.

    >>> log = ValueLog()
    >>> log.add("error", 0.31, "rad")
    >>> log.take()
    {'error': LoggedValue(value=0.31, unit='rad')}
    """

    def __init__(self) -> None:
        self._series: dict[str, tuple[str, str]] = {}
        self._values: dict[str, LoggedValue] = {}

    def add(self, name: str, value: Logged, unit: str = "") -> None:
        """Log a value. Raises UsageError for a name, a value or a unit that cannot be logged."""
        plain, kind = _to_plain(name, value)
        series = kind, unit
        if not isinstance(name, str) or name not in self._series:
            self._begin_series(name, series)
        elif series != self._series[name]:
            raise _build_change_error(name, self._series[name], series)
        self._values[str.__str__(name)] = LoggedValue(plain, str.__str__(unit))  # both may be members of enumerations

    def take(self) -> Mapping[str, LoggedValue]:
        """Return the values by name, and begin a new tick."""
        if not self._values:
            return NOTHING_LOGGED
        values, self._values = self._values, {}
        return values

    def _begin_series(self, name: str, series: tuple[str, str]) -> None:
        if not is_log_name(name):
            remedy = f"Take a letter, and up to {MAX_NAME_LENGTH - 1} letters of a to z, digits, _ and -"
            raise _build_error(name, f"this is not a valid name. {remedy}", "log-name")
        if not is_log_unit(series[1]):
            remedy = f'Write its symbol in up to {MAX_UNIT_LENGTH} characters, such as "rad/s"'
            raise _build_error(name, f"the unit is {reprlib.repr(series[1])}. {remedy}", "log-unit")
        if len(self._series) >= MAX_NAMES:
            remedy = "Put what changes into the value instead of the name"
            raise _build_error(
                name, f"the run has logged {MAX_NAMES} other names, which is the limit. {remedy}", "log-names"
            )
        self._series[name] = series


def is_log_name(name: object) -> bool:
    """Return whether a value can be logged under a name."""
    return isinstance(name, str) and _NAME.fullmatch(name) is not None


def is_log_unit(unit: object) -> bool:
    """Return whether a text can be the unit of a logged value."""
    return isinstance(unit, str) and len(unit) <= MAX_UNIT_LENGTH and unit.isprintable()


def _to_plain(name: str, value: Any) -> tuple[Logged, str]:
    """Return a value as a float, int, bool or str, and its type as a noun."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        value = value.item()
    if isinstance(value, np.floating):  # a long double, for which Python has no type
        value = float(value)
    if isinstance(value, bool):
        return value, "boolean"
    if isinstance(value, float):
        return float(value), "number"
    if isinstance(value, int):
        return _require_small(name, int(value)), "number"
    if isinstance(value, str):
        return _require_short(name, value), "text"
    problem = f"the value is {reprlib.repr(value)}, of the type {type(value).__name__}"
    raise _build_error(name, f"{problem}. Log a number, a boolean or a text", "log-value")


def _require_small(name: str, number: int) -> int:
    if abs(number) > MAX_INTEGER:
        raise _build_error(name, "the integer is beyond 2**53. Log it as a float or a text", "log-value")
    return number


def _require_short(name: str, text: str) -> str:
    """Return a text with escapes in place of lone surrogates, which UTF-8 cannot encode."""
    plain = str.encode(text[: MAX_TEXT_LENGTH + 1], errors="backslashreplace").decode()
    if len(plain) > MAX_TEXT_LENGTH:
        problem = f"the text is longer than {MAX_TEXT_LENGTH} characters. Log a shorter text, or print it"
        raise _build_error(name, problem, "log-value")
    return plain


def _build_change_error(name: str, before: tuple[str, str], now: tuple[str, str]) -> UsageError:
    texts = [f"a {kind} with the unit {unit!r}" if unit else f"a {kind} without a unit" for kind, unit in (before, now)]
    problem = f"the value was {texts[0]}, and is now {texts[1]}. Log it under another name"
    return _build_error(name, problem, "log-changed")


def _build_error(name: object, problem: str, kind: str) -> UsageError:
    shown = reprlib.repr(name)
    return UsageError(f"robot.log({shown}): {problem}", kind=kind, name=shown)

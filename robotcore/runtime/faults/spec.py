"""Fault specifications: ``TARGET EFFECT[=VALUE] [KEY=VALUE …]``, from a text or from a TOML file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from typing import Annotated, NamedTuple

from pydantic import BeforeValidator, Field, ValidationError

from robotcore.description import StrictModel, read_table
from robotcore.description.validation import find_mistakes
from robotcore.errors import DescriptionError, UsageError
from robotcore.runtime.faults.base import Fault

GRAMMAR = "TARGET EFFECT[=VALUE] [KEY=VALUE …]"
EXAMPLE = "camera drop=0.2 after=5"

VALUE = "value"
"""The name of the field in a `Fault` that contains the effect's value, such as 0.2 in ``drop=0.2``."""

MAX_QUOTED_LENGTH = 60
"""The largest number of characters of a user's text in a message."""

_NAME = r"[A-Za-z][A-Za-z0-9_-]*"
_FORM = re.compile(rf"({_NAME}) ({_NAME})(?:=(\S+))?((?: {_NAME}=\S+)*)")


@dataclass(frozen=True)
class Spec:
    """A parsed specification of a fault. Its names and values are not checked yet.

    >>> str(Spec.parse("  camera drop=0.20   lasts=3.0 after=5 "))
    'camera drop=0.2 after=5 lasts=3'
    """

    target: str
    effect: str
    value: str | None = None
    parameters: tuple[tuple[str, str], ...] = ()

    @classmethod
    def parse(cls, text: str) -> Spec:
        """Parse a specification. Raises UsageError if its form is wrong."""
        parts = _FORM.fullmatch(" ".join(text.split()))
        pairs = [word.split("=", 1) for word in parts[4].split()] if parts else []
        parameters = {key: _canonical(value) for key, value in pairs}
        if not parts or not parts[0].isprintable() or len(parameters) < len(pairs) or VALUE in parameters:
            form = f'Write {GRAMMAR}, each KEY once, such as "{EXAMPLE}"'
            raise UsageError(f"{quote_text(text)} is no fault. {form}", kind="fault-form")
        target, effect, value, _ = parts.groups()
        return cls(target, effect.replace("-", "_"), value and _canonical(value), tuple(sorted(parameters.items())))

    def __str__(self) -> str:
        """Return the canonical form: sorted parameters, and each number with as few digits as possible."""
        effect = self.effect if self.value is None else f"{self.effect}={self.value}"
        return " ".join([self.target, effect, *(f"{key}={value}" for key, value in self.parameters)])

    @property
    def after_s(self) -> float:
        """The time in seconds at which the fault begins."""
        return float(dict(self.parameters).get("after", 0.0))


def quote_text(text: str) -> str:
    """Return a user's text in quotes for a message. A long text is shortened to `MAX_QUOTED_LENGTH` characters."""
    return repr(text if len(text) <= MAX_QUOTED_LENGTH else f"{text[:MAX_QUOTED_LENGTH]}…")


def _canonical(value: str) -> str:
    with suppress(ValueError):
        return repr(float(value)).removesuffix(".0")
    return value


MAX_INJECTED_FAULTS = 100
"""The largest number of faults in a run. Each fault adds a layer to its devices."""


def _read_word(value: object) -> str:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < inf
    if is_number or isinstance(value, str):
        return str(value)
    raise ValueError("is neither a number nor a text; write a number, or a text in quotes")


_Words = dict[str, Annotated[str, BeforeValidator(_read_word)]]


class _File(StrictModel):
    fault: Annotated[tuple[_Words, ...], Field(min_length=1, description="one or more tables: [[fault]]")]


def read_specs(texts: Iterable[str]) -> tuple[str, ...]:
    """Return the canonical forms of the specifications of faults.

    texts: specifications, or names of TOML files that contain specifications.

    Raises UsageError if the form of a specification is wrong. `plan_faults` checks whether it fits the robot.
    """
    specs: list[str] = []
    for text in texts:
        is_file = text.endswith(".toml") and "=" not in text
        specs += map(str, _read(text) if is_file else [Spec.parse(text)])
    if len(specs) > MAX_INJECTED_FAULTS:
        raise UsageError(
            f"a run can have at most {MAX_INJECTED_FAULTS} faults, got {len(specs)}. Leave some out",
            kind="too-many-faults",
            count=len(specs),
        )
    return tuple(specs)


def _read(file: str) -> list[Spec]:
    table = read_table(file)
    try:
        faults = _File.model_validate(table, strict=True).fault
    except ValidationError as error:
        raise DescriptionError.of_all(file, find_mistakes(error, _File, table)) from error
    return [_spec(dict(words), file, f"fault[#{number}]") for number, words in enumerate(faults, start=1)]


def _spec(words: _Words, file: str, place: str) -> Spec:
    target, effect = words.pop("target", ""), words.pop("effect", "")
    first = f"{effect}={words.pop(VALUE)}" if VALUE in words else effect
    try:
        return Spec.parse(" ".join([target, first, *(f"{key}={word}" for key, word in words.items())]))
    except UsageError as error:
        raise UsageError(f"{file}: {place}: {error}", kind=error.kind, file=file, place=place) from error


class Parameter(NamedTuple):
    """One parameter of a fault."""

    name: str
    """The key of the parameter in a specification."""
    unit: str
    """The unit of the value, such as ``seconds``."""
    limits: str
    """The limits of the value, such as ``from 0 to 1``. Empty if there are none."""
    required: bool
    """Whether a specification must contain the parameter."""


def parameters_of(effect: str, fault: type[Fault]) -> list[Parameter]:
    """Return the parameters of a fault. The first one is the value of the effect, with the effect's name."""
    parameters = []
    for name, schema in fault.model_json_schema().get("properties", {}).items():
        number = schema.get("anyOf", [schema])[0]
        unit = schema.get("description") or number.get("description") or VALUE
        limits = " ".join(f"{word} {number[key]:g}" for word, key in _BOUNDS.items() if key in number)
        is_required = fault.model_fields[name].is_required()
        parameters.append(Parameter(effect if name == VALUE else name, unit, limits, is_required))
    return sorted(parameters, key=lambda each: (each.name != effect, not each.required, each.name))


_BOUNDS = {"from": "minimum", "above": "exclusiveMinimum", "to": "maximum", "below": "exclusiveMaximum"}


def forms_of(effect: str, fault: type[Fault]) -> list[str]:
    """Return the form of each part of a fault's specification: ``drop=PROBABILITY``, ``[after=SECONDS]``, ...

    The first part is the effect. Optional parameters are in brackets.
    """
    parameters = parameters_of(effect, fault)
    written = [f"{each.name}={each.unit.upper().replace(' ', '_')}" for each in parameters]
    forms = [form if each.required else f"[{form}]" for form, each in zip(written, parameters, strict=True)]
    return forms if VALUE in fault.model_fields else [effect, *forms]

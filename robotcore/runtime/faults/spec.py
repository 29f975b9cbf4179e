"""Fault specifications: ``TARGET EFFECT[=VALUE] [KEY=VALUE …]``, from a text or from a TOML file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator, Field, ValidationError

from robotcore.description import StrictModel, read_table
from robotcore.description.validation import find_mistakes
from robotcore.errors import DescriptionError, UsageError
from robotcore.runtime.faults.base import Fault

GRAMMAR = "TARGET EFFECT[=VALUE] [KEY=VALUE …]"
EXAMPLE = "camera drop=0.2 after=5"

MAX_QUOTED_LENGTH = 60
"""The largest number of characters of a user's text in a message."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


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
        words = text.split()
        if len(words) < 2:
            raise _build_form_error(text, "the effect is missing" if words else "the text is empty")
        target, (effect, value), *rest = words[0], *(_split_word(text, word) for word in words[1:])
        for key, given in rest:
            if given is None:
                raise _build_form_error(text, f"{quote_text(key)} has no value")
            if [other for other, _ in rest].count(key) > 1:
                raise _build_form_error(text, f"{key} is given twice")
        parameters = [(key, given) for key, given in rest if given is not None]
        return cls(_check_name(text, target), effect.replace("-", "_"), value, tuple(sorted(parameters)))

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


def _build_form_error(text: str, mistake: str) -> UsageError:
    return UsageError(f'{quote_text(text)}: {mistake}. Write {GRAMMAR}, such as "{EXAMPLE}"', kind="fault-form")


def _split_word(text: str, word: str) -> tuple[str, str | None]:
    key, sign, value = word.partition("=")
    if sign and not value:
        raise _build_form_error(text, f"{quote_text(word)} has no value")
    return _check_name(text, key), _canonical(text, value) if sign else None


def _check_name(text: str, word: str) -> str:
    if not _NAME.fullmatch(word):
        raise _build_form_error(text, f"{quote_text(word)} is no name")
    return word


def _canonical(text: str, value: str) -> str:
    if not value.isprintable():
        raise _build_form_error(text, f"{quote_text(value)} cannot be printed")
    with suppress(ValueError):
        return repr(float(value)).removesuffix(".0")
    return value


LARGEST = 1e300

MAX_INJECTED_FAULTS = 100
"""The largest number of faults in a run. Each fault adds a layer to its devices."""


def _read_word(value: Any) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < LARGEST:
        return repr(float(value))
    raise ValueError("is neither a number nor a text; write a number, or a text in quotes")


Word = Annotated[str, BeforeValidator(_read_word)]


class _File(StrictModel):
    fault: Annotated[tuple[dict[str, Word], ...], Field(min_length=1, description="one or more tables: [[fault]]")]


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


def _spec(words: dict[str, str], file: str, place: str) -> Spec:
    for key in ("target", "effect"):
        if key not in words:
            raise DescriptionError(file, f"{place}.{key}", "is missing", "Add it")
    target, effect, value = words.pop("target"), words.pop("effect"), words.pop("value", None)
    first = effect if value is None else f"{effect}={value}"
    try:
        return Spec.parse(" ".join([target, first, *(f"{key}={word}" for key, word in words.items())]))
    except UsageError as error:
        raise UsageError(f"{file}: {place}: {error}", kind=error.kind, file=file, place=place) from error


VALUE = "value"
"""The name of the field in a `Fault` that contains the effect's value, such as 0.2 in ``drop=0.2``."""


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

"""Several faults in one file: TOML, a table ``[[fault]]`` for each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationError

from robotcore.description import StrictModel, read_table
from robotcore.description.validation import find_mistakes
from robotcore.errors import DescriptionError, UsageError
from robotcore.runtime.faults.spec import Spec

SUFFIX = ".toml"
LARGEST = 1e300

MAX_INJECTED_FAULTS = 100
"""The most faults of a run. Each fault is a layer over a device."""


def _word(value: Any) -> str:
    """Return a value of TOML as it is written in a spec."""
    match value:
        case str():
            return value
        case bool():
            pass
        case int() | float() if abs(value) < LARGEST:
            return repr(float(value))
    raise ValueError("is neither a number nor a word; write a number, or a word in quotes")


Word = Annotated[str, BeforeValidator(_word)]


class _File(StrictModel):
    fault: Annotated[tuple[dict[str, Word], ...], Field(min_length=1, description="one or more tables: [[fault]]")]


def specs_in(texts: Iterable[str]) -> tuple[str, ...]:
    """Return specs in their canonical form; a file among them stands for those that are in it, in its order.

    Raises UsageError in one line; what is wrong for the robot is told when a run is planned.
    """
    specs = [str(spec) for text in texts for spec in (_read(text) if _is_file(text) else [Spec.parse(text)])]
    if len(specs) > MAX_INJECTED_FAULTS:
        raise UsageError(f"a run can have at most {MAX_INJECTED_FAULTS} faults, got {len(specs)}. Leave some out")
    return tuple(specs)


def _is_file(text: str) -> bool:
    return text.endswith(SUFFIX) and "=" not in text


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
        raise UsageError(f"{file}: {place}: {error}") from error

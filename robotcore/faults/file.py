"""Several faults in one file: TOML, a table ``[[fault]]`` for each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field, ValidationError

from robotcore.description import Described, read_table
from robotcore.description.faults import fault_of
from robotcore.errors import DescriptionError, UsageError
from robotcore.faults.spec import Spec

SUFFIX = ".toml"
LARGEST = 1e300


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


class _Written(Described):
    """A fault in a file; whatever else stands there is a parameter."""

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Word]

    target: str
    effect: str
    value: Word | None = None

    @property
    def text(self) -> str:
        value = "" if self.value is None else f"={self.value}"
        rest = [f"{key}={word}" for key, word in self.__pydantic_extra__.items()]
        return " ".join([self.target, f"{self.effect}{value}", *rest])


class _File(Described):
    fault: Annotated[tuple[_Written, ...], Field(min_length=1, description="one or more tables: [[fault]]")]


def specs_in(texts: Iterable[str]) -> tuple[str, ...]:
    """Return specs in their canonical form; a file among them stands for those that are in it, in its order.

    Raises UsageError in one line; what is wrong for the robot is told when a run is planned.
    """
    return tuple(str(spec) for text in texts for spec in (_read(text) if _is_file(text) else [Spec.parse(text)]))


def _is_file(text: str) -> bool:
    return text.endswith(SUFFIX) and "=" not in text


def _read(file: str) -> list[Spec]:
    table = read_table(file)
    try:
        written = _File.model_validate(table, strict=True).fault
    except ValidationError as error:
        raise DescriptionError(file, *fault_of(error, _File, table)) from error
    return [_spec(fault, f"{file}: fault[#{number}]") for number, fault in enumerate(written, start=1)]


def _spec(fault: _Written, place: str) -> Spec:
    try:
        return Spec.parse(fault.text)
    except UsageError as error:
        raise UsageError(f"{place}: {error}") from error

"""Mistakes in a description: key, problem and remedy of each, from pydantic's errors and the models' schemas."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import BaseModel, ValidationError

from robotcore.errors import suggestion

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails


Schema = dict[str, Any]


def keys_at(model: type[BaseModel], place: Sequence[str | int]) -> list[str]:
    """Return which keys there may be at a place of a model."""
    return list(_at(model, place).get("properties", ()))


def written_form(model: type[BaseModel], place: Sequence[str | int]) -> str | None:
    """Return how the value at a place is written in a file.

    As its type's description says, else one of the few that there are; None where neither is so.
    """
    *outer, key = place
    value = _inside(_at(model, outer), key)
    form: str | None = value.get("description") or " or ".join(map(json.dumps, value.get("enum", ())))
    return form or None


def _at(model: type[BaseModel], place: Sequence[str | int]) -> Schema:
    here = _schema(model)
    parts = here.get("$defs", {})
    for part in place:
        here = _resolved(_inside(here, part), parts)
    return here


@cache
def _schema(model: type[BaseModel]) -> Schema:
    """Return a model's schema, made once: it takes 30 ms, and a file may have a fault in every line."""
    return model.model_json_schema()


def _inside(schema: Schema, part: str | int) -> Schema:
    """Return the schema of an item, of one kind of item, or of a key's value."""
    if isinstance(part, int):
        return dict(schema.get("items", {}))
    if part in (kinds := schema.get("discriminator", {}).get("mapping", {})):
        return {"$ref": kinds[part]}
    return dict(schema.get("properties", {}).get(part, {}))


def _resolved(schema: Schema, parts: Schema) -> Schema:
    """Return what a schema refers to, the None of an optional part left out.

    A part with a description of its own is wrapped in ``allOf`` by pydantic before 2.9.
    """
    first = (schema.get("anyOf") or schema.get("allOf") or [schema])[0]
    return dict(parts[first["$ref"].rpartition("/")[2]]) if "$ref" in first else first


BACKENDS = "backends"
"""The field that gathers the backends' sections; in a file they stand at the top."""

MAX_SHOWN_CHARACTERS = 40
"""Of a value or key from a file, in a message."""

MAX_LIBRARY_MESSAGE = 200
"""The most characters of a library's own message about a file."""

MAX_FILE_ERRORS = 50
"""The most errors of one file that are reported: more of them usually have one cause."""

_UNITS = {
    "_kg": "kg",
    "_m": "m",
    "_m_s2": "m/s²",
    "_nm": "N·m",
    "_px": "px",
    "_rad": "rad",
    "_rad_s": "rad/s",
    "_rad_s2": "rad/s²",
    "_s": "s",
    "_v": "V",
}
"""By the ends of keys."""

_TAGS = ("kind", "shape")
_MESSAGES = {
    "missing": "is missing",
    "extra_forbidden": "is unknown",
    "model_type": "should be a table",
    "model_attributes_type": "should be a table",
    "dict_type": "should be a table",
    "tuple_type": "should be a list",
    "float_parsing": "should be a number",
    "bool_type": "should be true or false",
    "int_type": "should be a whole number",
    "string_type": "should be a string in quotes",
}
_BOUNDS = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
_PLAINER = (("Input ", ""), ("greater than or equal to", "at least"), ("less than or equal to", "at most"))


class Mistake(NamedTuple):
    """One thing that is wrong; the key is dotted, things in lists by name: ``devices[nose].mount.x_m``."""

    key: str
    fault: str
    remedy: str


def first_mistake(error: ValidationError) -> tuple[str, str]:
    """Return the key of the first fault of a model, dotted, and what is wrong with it."""
    ranks = {"extra_forbidden": 0, "missing": 2}  # a misspelt key before the key that is missing for it
    found = min(error.errors(include_url=False), key=lambda fault: ranks.get(fault["type"], 1))
    return dotted_key(found["loc"], {}), _format_message(found)


def find_mistakes(
    error: ValidationError, model: type[BaseModel], data: Mapping[str, Any], sections: Sequence[str] = ()
) -> list[Mistake]:
    """Return what to say of ``data`` that is no such model, in its order; ``sections`` may stand at its top too.

    What only follows from another fault is left out: a key that is missing because it is misspelt, a list that is too
    short because an item in it is wrong.
    """
    all_found = error.errors(include_url=False)
    lists = {found["loc"][:-1] for found in all_found}
    causes = [found for found in all_found if found["type"] != "too_short" or found["loc"] not in lists]
    found_faults = dict.fromkeys(_mistake(found, model, data, sections) for found in causes[: MAX_FILE_ERRORS + 1])
    return limit_errors(fault for fault in found_faults if not _is_misspelt(fault, found_faults))


def limit_errors(faults: Iterable[tuple[str, str, str]]) -> list[Mistake]:
    """Return at most `MAX_FILE_ERRORS` errors, and then one that says that there are more."""
    found_faults = [Mistake(*fault) for fault in islice(faults, MAX_FILE_ERRORS + 1)]
    more = Mistake("", f"more than {MAX_FILE_ERRORS} errors; only the first are shown", "Correct these first")
    return [*found_faults[:MAX_FILE_ERRORS], *[more] * (len(found_faults) > MAX_FILE_ERRORS)]


def _is_misspelt(missing: Mistake, mistakes: Iterable[Mistake]) -> bool:
    """Return whether one of the faults is another spelling of a key that is missing."""
    *table, key = missing.key.split(".")
    meant = f"Did you mean {key!r}?"
    return missing.fault == _MESSAGES["missing"] and any(
        other.key.split(".")[:-1] == table and other.remedy.endswith(meant) for other in mistakes
    )


def _mistake(found: ErrorDetails, model: type[BaseModel], data: Mapping[str, Any], sections: Sequence[str]) -> Mistake:
    kind, loc, key, message = found["type"], found["loc"], dotted_key(found["loc"], data), _format_message(found)
    if form := _form(model, found):
        return Mistake(
            dotted_key(_place(found), data), f"should be {form}, got {_format_value(found['input'])}", "Correct it"
        )
    if kind == "extra_forbidden":
        known = [*_keys_beside(model, loc), *(sections if len(loc) == 1 else ())]
        return Mistake(key, message, f"Correct it or take it out. {suggestion(_format_key(loc[-1]), known)}")
    if kind == "missing":
        form = written_form(model, loc)
        return Mistake(key, message, f"Add it: {form}" if form else "Add it")
    if kind.startswith("union_tag"):
        return _unknown_kind(key, found)
    if kind == "value_error":
        fault, _, remedy = message.rpartition("; ")
        return Mistake(key, fault, remedy[:1].upper() + remedy[1:])
    return Mistake(key, message, "Correct it")


def _keys_beside(model: type[BaseModel], loc: Sequence[str | int]) -> list[str]:
    """Return which keys there may be where ``loc`` ends in one that there may not."""
    return [key for key in keys_at(model, loc[:-1]) if key != BACKENDS]


def _form(model: type[BaseModel], found: ErrorDetails) -> str | None:
    """Return how a value is written that has the wrong type or length, where its own type says so."""
    is_shapeless = found["type"].endswith("_type") or found["type"] in ("too_long", "too_short")
    return written_form(model, _place(found)) if is_shapeless or _is_cut_short(found) else None


def _place(found: ErrorDetails) -> Sequence[str | int]:
    """Return where the value stands that is wrong; that is a list, not the item that it lacks."""
    return found["loc"][:-1] if _is_cut_short(found) else found["loc"]


def _is_cut_short(found: ErrorDetails) -> bool:
    return found["type"] == "missing" and isinstance(found["loc"][-1], int)


def _unknown_kind(key: str, found: ErrorDetails) -> Mistake:
    """Return what to say of a thing that does not tell which of several kinds it is, or tells none of them."""
    key += "." + str(found["ctx"]["discriminator"]).strip("'")
    if found["type"] == "union_tag_not_found":
        return Mistake(key, "is missing", "Add it: it says what sort of thing this is")
    tag, known = str(found["ctx"]["tag"])[:MAX_SHOWN_CHARACTERS], re.findall(r"'(\w+)'", found["ctx"]["expected_tags"])
    return Mistake(key, f"{tag!r} is unknown", suggestion(tag, known))


def dotted_key(loc: Sequence[str | int], data: Any) -> str:
    """Return the key of a place in a file, dotted, with things in lists by name: ``devices[nose].mount``."""
    key, here, in_list = "", data, False
    for part in loc:
        if in_list and isinstance(here, dict) and part in [here.get(tag) for tag in _TAGS]:
            in_list = False
            continue
        in_list = isinstance(part, int)
        here = _item(here, part)
        if in_list:
            key += f"[{_label(here, part)}]"
        elif (key, part) != ("", BACKENDS):
            key += f".{_format_key(part)}" if key else _format_key(part)
    return key


def _item(data: Any, part: str | int) -> Any:
    try:
        return data[part]
    except (LookupError, TypeError):
        return None


def _label(item: Any, index: str | int) -> str:
    """Return the name of a thing in a list, or its number: the first is #1."""
    name = item.get("name") if isinstance(item, dict) else None
    return _format_key(name) if name and isinstance(name, str) else f"#{int(index) + 1}"


def _format_key(key: str | int) -> str:
    """Return a key as it stands in a file, in quotes where it needs them."""
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]{1,40}", text) else repr(text[:MAX_SHOWN_CHARACTERS])


def _format_message(found: ErrorDetails) -> str:
    message = _MESSAGES.get(found["type"], found["msg"])
    if found["type"] in ("missing", "extra_forbidden", "value_error"):
        return message.removeprefix("Value error, ")
    for formal, plain in _PLAINER:
        message = message.replace(formal, plain, 1)
    if found["type"] in _BOUNDS:
        message += _unit(found["loc"])
    return f"{message}, got {_format_value(found['input'])}"


def _unit(loc: Sequence[str | int]) -> str:
    """Return the unit at the end of a key, after a space; nothing for a key without one."""
    key = next((part for part in reversed(loc) if isinstance(part, str)), "")
    ends = [end for end in _UNITS if key.endswith(end)]
    return f" {_UNITS[max(ends, key=len)]}" if ends else ""


def _format_value(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, int) and abs(value) >= 10**MAX_SHOWN_CHARACTERS:
        return f"a number of {value.bit_length()} bits"
    return repr(value[:MAX_SHOWN_CHARACTERS] if isinstance(value, str) else value)

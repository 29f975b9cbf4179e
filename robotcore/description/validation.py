"""Converts the errors of pydantic to mistakes with a key, a problem and a remedy."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import islice
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from robotcore.description.devices import load_model
from robotcore.description.drive import DIFFERENTIAL
from robotcore.description.types import MIN_DEGREES, build_turn_mistake
from robotcore.errors import Mistake, RobotcoreError
from robotcore.plugins import kind_names
from robotcore.text import suggestion

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails


Schema = dict[str, Any]


def _get_form(model: type[BaseModel], path: Sequence[str | int]) -> str | None:
    """Return the form of a value in a file, such as ``[from, to]``, or None if the model does not describe it."""
    *outer, key = path
    value = _find_child(_find_schema(model, outer), key)
    form: str | None = value.get("description") or " or ".join(map(json.dumps, value.get("enum", ())))
    return form or None


def _find_schema(model: type[BaseModel], path: Sequence[str | int]) -> Schema:
    here = _get_schema(model)
    definitions = here.get("$defs", {})
    for part in path:
        here = _resolve(_find_child(here, part), definitions)
    return here


@cache
def _get_schema(model: type[BaseModel]) -> Schema:
    # Pydantic needs 30 ms for a schema, which each mistake in a file may need.
    return model.model_json_schema()


def _find_child(schema: Schema, part: str | int) -> Schema:
    if isinstance(part, int):
        return dict(schema.get("items", {}))
    if part in (kinds := schema.get("discriminator", {}).get("mapping", {})):
        return {"$ref": kinds[part]}
    return dict(schema.get("properties", {}).get(part, {}))


def _resolve(schema: Schema, definitions: Schema) -> Schema:
    # Optional values are in `anyOf`. Pydantic before 2.9 has `allOf` for a part with its own description.
    first = (schema.get("anyOf") or schema.get("allOf") or [schema])[0]
    return dict(definitions[first["$ref"].rpartition("/")[2]]) if "$ref" in first else first


BACKENDS = "backends"
"""The field of `RobotDescription` for the backends' sections. In a file, the sections are top-level tables."""

MAX_SHOWN_CHARACTERS = 40
"""The greatest number of characters of a key or a value that a message quotes."""

MAX_LIBRARY_MESSAGE = 200
"""The greatest number of characters of another library's message that a message quotes."""

MAX_FILE_ERRORS = 50
"""The greatest number of mistakes that are reported for one file."""

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
"""A mapping from the end of a key, such as ``_m``, to the unit of the key's value."""

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
    "int_parsing": "should be a whole number",
    "string_type": "should be a string in quotes",
}
_BOUNDS = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
_PLAINER = (("Input ", ""), ("greater than or equal to", "at least"), ("less than or equal to", "at most"))


_KINDS = {"missing": "missing-key", "extra_forbidden": "unknown-key", **dict.fromkeys(_BOUNDS, "out-of-bounds")}


def first_mistake(error: ValidationError) -> tuple[str, str]:
    """Return the dotted key and the problem of the first mistake in pydantic's error.

    >>> from robotcore.description import Body
    >>> try:
    ...     Body.model_validate({"length_m": -1.0})
    ... except ValidationError as error:
    ...     print(first_mistake(error))
    ('length_m', 'should be at least 0.001 m, got -1.0')
    """
    ranks = {"extra_forbidden": 0, "missing": 2}  # a misspelt key before the key that is missing for it
    found = min(error.errors(include_url=False), key=lambda mistake: ranks.get(mistake["type"], 1))
    return dotted_key(found["loc"], {}), _format_message(found)


def find_mistakes(
    error: ValidationError, model: type[BaseModel], data: Mapping[str, Any], sections: Sequence[str] = ()
) -> list[Mistake]:
    """Return the mistakes in the content of a file, in the order of the keys.

    Mistakes that follow from others are left out, such as a key that is missing because it is misspelt, or a list that
    is too short because one of its items is wrong.

    error: pydantic's error for the content.
    model: the model that refused the content.
    data: the content of the file.
    sections: further top-level keys that the file may have.
    """
    all_found = error.errors(include_url=False)
    lists = {found["loc"][:end] for found in all_found for end in range(len(found["loc"]))}
    causes = [found for found in all_found if found["type"] != "too_short" or found["loc"] not in lists]
    made = [_make_mistake(found, model, data, sections) for found in causes[: MAX_FILE_ERRORS + 1]]
    mistakes = {(each.key, each.problem): each for each in made}.values()
    return limit_errors(each for each in mistakes if not _is_misspelt(each, mistakes))


def limit_errors(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """Return the first `MAX_FILE_ERRORS` mistakes, and if there are more, a last item that reports this."""
    found = list(islice(mistakes, MAX_FILE_ERRORS + 1))
    if len(found) > MAX_FILE_ERRORS:
        problem = f"it has more than {MAX_FILE_ERRORS} errors, of which the first {MAX_FILE_ERRORS} are shown"
        found[-1] = Mistake(problem, "Correct these first", kind="too-many-mistakes")
    return found


def _is_misspelt(missing: Mistake, mistakes: Iterable[Mistake]) -> bool:
    """Return whether a mistake about an unknown key already suggests the missing key."""
    *table, key = missing.key.split(".")
    meant = f"Did you mean {key!r}?"
    return missing.problem == _MESSAGES["missing"] and any(
        other.key.split(".")[:-1] == table and other.remedy.endswith(meant) for other in mistakes
    )


def _make_mistake(
    found: ErrorDetails, model: type[BaseModel], data: Mapping[str, Any], sections: Sequence[str]
) -> Mistake:
    cause, path, key = found["type"], found["loc"], dotted_key(found["loc"], data)
    if form := _find_form(model, found):
        problem = f"should be {form}, got {format_value(found['input'])}"
        return Mistake(problem, kind="wrong-form", key=dotted_key(_find_path(found), data))
    if cause == "value_error":
        return Mistake.from_error(found["ctx"]["error"], key, "invalid-value")
    if cause.startswith("union_tag"):
        return _make_tag_mistake(key, found, model)
    if _is_in_degrees(found):
        return build_turn_mistake(found["input"], key)
    remedy = "Correct it"
    if cause == "extra_forbidden":
        keys = _find_schema(model, path[:-1]).get("properties", ())
        known = [key for key in (*keys, *(sections if len(path) == 1 else ())) if key != BACKENDS]
        remedy = f"Correct or remove the key. {suggestion(_format_key(path[-1]), known)}"
    elif cause == "missing":
        form = _get_form(model, path)
        remedy = f"Add it: {form}" if form else "Add it"
    return Mistake(_format_message(found), remedy, kind=_KINDS.get(cause, "wrong-value"), key=key)


def _is_in_degrees(found: ErrorDetails) -> bool:
    """Return whether a value is out of bounds, probably because it is an angle in degrees."""
    value = found["input"]
    is_bounded = found["type"] in _BOUNDS and isinstance(value, (int, float))
    return is_bounded and _format_unit(found["loc"]) == " rad" and abs(value) >= MIN_DEGREES


def _find_form(model: type[BaseModel], found: ErrorDetails) -> str | None:
    has_wrong_form = found["type"].endswith("_type") or found["type"] in ("too_long", "too_short")
    return _get_form(model, _find_path(found)) if has_wrong_form or _lacks_item(found) else None


def _find_path(found: ErrorDetails) -> Sequence[str | int]:
    # If a list lacks an item, the list is wrong.
    return found["loc"][:-1] if _lacks_item(found) else found["loc"]


def _lacks_item(found: ErrorDetails) -> bool:
    return found["type"] == "missing" and isinstance(found["loc"][-1], int)


def _make_tag_mistake(key: str, found: ErrorDetails, model: type[BaseModel]) -> Mistake:
    # The tag is the key that selects the model of an item, such as `kind`.
    name = str(found["ctx"]["discriminator"]).strip("'")
    key += f".{name}"
    if found["type"] == "union_tag_not_found":
        *outer, index = found["loc"]
        tags = _find_child(_find_schema(model, outer), index).get("discriminator", {}).get("mapping", {})
        return Mistake("is missing", f"Add it: {' or '.join(map(json.dumps, tags))}", kind="missing-tag", key=key)
    tag, known = str(found["ctx"]["tag"])[:MAX_SHOWN_CHARACTERS], re.findall(r"'(\w+)'", found["ctx"]["expected_tags"])
    if not isinstance(given := found["input"].get(name), str):
        problem = f"{_MESSAGES['string_type']}, got {format_value(given)}"
        return Mistake(problem, f"Name one: {', '.join(sorted(known))}", kind="wrong-value", key=key)
    problem, remedy = f"{tag!r} is unknown", suggestion(tag, known)
    if key.startswith("devices["):
        problem, remedy = _explain_unknown_kind(tag, problem, remedy)
    return Mistake(problem, remedy, kind="unknown-tag", key=key)


def _explain_unknown_kind(tag: str, problem: str, remedy: str) -> tuple[str, str]:
    """Return a problem and a remedy that say how to get a kind of device, or why a registered one cannot be loaded."""
    if tag in kind_names():
        try:
            load_model(tag)
        except RobotcoreError as error:
            problem, _, remedy = str(error).rpartition(". ")
    elif remedy.endswith("."):  # no known name is near
        remedy += " For another kind, install its package, or make one: robotcore new --kind NAME"
    return problem, remedy


def dotted_key(loc: Sequence[str | int], data: Any) -> str:
    """Return the dotted key of a path in a file, with the names of items in place of list indices.

    loc: the path, as keys and list indices.
    data: the content of the file.

    >>> dotted_key(("devices", 0, "mount"), {"devices": [{"name": "nose"}]})
    'devices[nose].mount'
    """
    key, here, in_list, is_new = "", data, False, False
    defaults = {"drive": [DIFFERENTIAL]}
    for part in loc:
        if is_new and isinstance(here, dict) and part in [here.get(tag) for tag in _TAGS] + defaults.get(key, []):
            is_new = in_list = False
            continue
        in_list, is_new = isinstance(part, int), True
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
    """Return the name of a list's item. Without a name, return its position, such as ``#1``."""
    name = item.get("name") if isinstance(item, dict) else None
    return _format_key(name) if name and isinstance(name, str) else f"#{int(index) + 1}"


def _format_key(key: str | int) -> str:
    # TOML needs quotes around a key with other characters.
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]{1,40}", text) else repr(text[:MAX_SHOWN_CHARACTERS])


def _format_message(found: ErrorDetails) -> str:
    message = _MESSAGES.get(found["type"], found["msg"])
    if found["type"] in ("missing", "extra_forbidden", "value_error"):
        return message.removeprefix("Value error, ")
    for formal, plain in _PLAINER:
        message = message.replace(formal, plain, 1)
    if found["type"] in _BOUNDS:
        message += _format_unit(found["loc"])
    return f"{message}, got {format_value(found['input'])}"


def _format_unit(loc: Sequence[str | int]) -> str:
    key = next((part for part in reversed(loc) if isinstance(part, str)), "")
    ends = [end for end in _UNITS if key.endswith(end)]
    return f" {_UNITS[max(ends, key=len)]}" if ends else ""


def format_value(value: Any) -> str:
    """Return a short text of a value in a file, for messages.

    >>> format_value(["imu"]), format_value("imu")
    ('a list of 1', "'imu'")
    """
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

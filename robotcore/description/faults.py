"""What pydantic found wrong with a description, a line for each: the key, the fault and the remedy."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import BaseModel, ValidationError

from robotcore.description.schema import keys_at, written_form
from robotcore.errors import suggestion

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

BACKENDS = "backends"
"""The field that gathers the backends' sections; in a file they stand at the top."""

LONGEST = 40
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


class Fault(NamedTuple):
    """One thing that is wrong; the key is dotted, things in lists by name: ``devices[nose].mount.x_m``."""

    key: str
    fault: str
    remedy: str


def first_fault(error: ValidationError) -> tuple[str, str]:
    """Return the key of the first fault of a model, dotted, and what is wrong with it."""
    ranks = {"extra_forbidden": 0, "missing": 2}  # a misspelt key before the key that is missing for it
    found = min(error.errors(include_url=False), key=lambda fault: ranks.get(fault["type"], 1))
    return dotted_key(found["loc"], {}), _message(found)


def faults_of(
    error: ValidationError, model: type[BaseModel], data: Mapping[str, Any], sections: Sequence[str] = ()
) -> list[Fault]:
    """Return what to say of ``data`` that is no such model, in its order; ``sections`` may stand at its top too.

    What only follows from another fault is left out: a key that is missing because it is misspelt, a list that is too
    short because an item in it is wrong.
    """
    all_found = error.errors(include_url=False)
    lists = {found["loc"][:-1] for found in all_found}
    causes = [found for found in all_found if found["type"] != "too_short" or found["loc"] not in lists]
    found_faults = dict.fromkeys(_fault(found, model, data, sections) for found in causes[: MAX_FILE_ERRORS + 1])
    return limit_errors(fault for fault in found_faults if not _is_misspelt(fault, found_faults))


def limit_errors(faults: Iterable[tuple[str, str, str]]) -> list[Fault]:
    """Return at most `MAX_FILE_ERRORS` errors, and then one that says that there are more."""
    found_faults = [Fault(*fault) for fault in islice(faults, MAX_FILE_ERRORS + 1)]
    more = Fault("", f"more than {MAX_FILE_ERRORS} errors; only the first are shown", "Correct these first")
    return [*found_faults[:MAX_FILE_ERRORS], *[more] * (len(found_faults) > MAX_FILE_ERRORS)]


def _is_misspelt(missing: Fault, told: Iterable[Fault]) -> bool:
    """Return whether one of the faults is another spelling of a key that is missing."""
    *table, key = missing.key.split(".")
    meant = f"Did you mean {key!r}?"
    return missing.fault == _MESSAGES["missing"] and any(
        other.key.split(".")[:-1] == table and other.remedy.endswith(meant) for other in told
    )


def _fault(found: ErrorDetails, model: type[BaseModel], data: Mapping[str, Any], sections: Sequence[str]) -> Fault:
    kind, loc, key, message = found["type"], found["loc"], dotted_key(found["loc"], data), _message(found)
    if form := _form(model, found):
        return Fault(dotted_key(_place(found), data), f"should be {form}, got {_told(found['input'])}", "Correct it")
    if kind == "extra_forbidden":
        known = [*_keys_beside(model, loc), *(sections if len(loc) == 1 else ())]
        return Fault(key, message, f"Correct it or take it out. {suggestion(_shown(loc[-1]), known)}")
    if kind == "missing":
        form = written_form(model, loc)
        return Fault(key, message, f"Add it: {form}" if form else "Add it")
    if kind.startswith("union_tag"):
        return _unknown_kind(key, found)
    if kind == "value_error":
        fault, _, remedy = message.rpartition("; ")
        return Fault(key, fault, remedy[:1].upper() + remedy[1:])
    return Fault(key, message, "Correct it")


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


def _unknown_kind(key: str, found: ErrorDetails) -> Fault:
    """Return what to say of a thing that does not tell which of several kinds it is, or tells none of them."""
    key += "." + str(found["ctx"]["discriminator"]).strip("'")
    if found["type"] == "union_tag_not_found":
        return Fault(key, "is missing", "Add it: it says what sort of thing this is")
    tag, known = str(found["ctx"]["tag"])[:LONGEST], re.findall(r"'(\w+)'", found["ctx"]["expected_tags"])
    return Fault(key, f"{tag!r} is unknown", suggestion(tag, known))


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
            key += f".{_shown(part)}" if key else _shown(part)
    return key


def _item(data: Any, part: str | int) -> Any:
    try:
        return data[part]
    except (LookupError, TypeError):
        return None


def _label(item: Any, index: str | int) -> str:
    """Return the name of a thing in a list, or its number: the first is #1."""
    name = item.get("name") if isinstance(item, dict) else None
    return _shown(name) if name and isinstance(name, str) else f"#{int(index) + 1}"


def _shown(key: str | int) -> str:
    """Return a key as it stands in a file, in quotes where it needs them."""
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]{1,40}", text) else repr(text[:LONGEST])


def _message(found: ErrorDetails) -> str:
    message = _MESSAGES.get(found["type"], found["msg"])
    if found["type"] in ("missing", "extra_forbidden", "value_error"):
        return message.removeprefix("Value error, ")
    for formal, plain in _PLAINER:
        message = message.replace(formal, plain, 1)
    if found["type"] in _BOUNDS:
        message += _unit(found["loc"])
    return f"{message}, got {_told(found['input'])}"


def _unit(loc: Sequence[str | int]) -> str:
    """Return the unit at the end of a key, after a space; nothing for a key without one."""
    key = next((part for part in reversed(loc) if isinstance(part, str)), "")
    ends = [end for end in _UNITS if key.endswith(end)]
    return f" {_UNITS[max(ends, key=len)]}" if ends else ""


def _told(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, int) and abs(value) >= 10**LONGEST:
        return f"a number of {value.bit_length()} bits"
    return repr(value[:LONGEST] if isinstance(value, str) else value)

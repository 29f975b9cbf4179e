"""What a description's model says of a place in it, in its JSON schema."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from typing import Any

from pydantic import BaseModel

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

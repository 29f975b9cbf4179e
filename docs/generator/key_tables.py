"""Tables of the keys of models: of robots' and worlds' files, of device drivers and of backends' options."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from enum import Enum
from functools import cache
from itertools import pairwise
from types import ModuleType
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

TYPES = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "a table",
}
"""The words for the types of JSON schemas."""


class LenientSchema(GenerateJsonSchema):
    """Generates the JSON schema of a model, in which a value of a class of Python has an empty schema."""

    def handle_invalid_for_json_schema(self, schema: Any, error_info: str) -> dict[str, Any]:
        return {}


def format_keys(model: type[BaseModel], leave_out: tuple[str, ...] = ()) -> str:
    """Return a Markdown table of a model's keys, with their values, defaults and meanings.

    leave_out: the keys that the table does not contain.
    """
    schema = model.model_json_schema(schema_generator=LenientSchema)
    rows = [
        "| key | value | default | meaning |",
        "| --- | --- | --- | --- |",
        *(
            f"| `{key}` | {_format_value(found, schema)} | {_format_default(model, key)} | {_describe(model, key)} |"
            for key, found in schema.get("properties", {}).items()
            if key not in leave_out
        ),
    ]
    return "\n".join(rows) if len(rows) > 2 else "It has no keys of its own."


def list_tables(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """Yield the models that the fields of a model contain, each once, in the order of the fields."""
    seen: set[type[BaseModel]] = set()

    def visit(annotation: Any) -> Iterator[type[BaseModel]]:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel) and annotation not in seen:
            seen.add(annotation)
            yield annotation
            yield from list_fields(annotation)
        for part in get_args(annotation):
            yield from visit(part)

    def list_fields(owner: type[BaseModel]) -> Iterator[type[BaseModel]]:
        for field in owner.model_fields.values():
            yield from visit(field.annotation)

    return list_fields(model)


def read_summary(documented: object) -> str:
    """Return the first paragraph of a docstring in one line."""
    return " ".join((inspect.getdoc(documented) or "").partition("\n\n")[0].split())


def _format_value(found: dict[str, Any], schema: dict[str, Any]) -> str:
    match found:
        case {"enum": values}:
            text = " or ".join(f'`"{value}"`' for value in values)
        case {"const": value}:
            text = f'`"{value}"`'
        case {"description": description}:
            text = _escape(description)
        case {"$ref": reference}:
            name = reference.rpartition("/")[2]
            target = schema["$defs"][name]
            text = _format_value(target, schema) if "enum" in target else f"a table, [{name}](#{name.lower()})"
        case {"anyOf": options} | {"oneOf": options}:
            kinds = [_format_value(option, schema) for option in options if option.get("type") != "null"]
            text = " or ".join(dict.fromkeys(kinds))
        case {"type": "array"}:
            items = found.get("prefixItems") or [found.get("items", {})]
            text = "a list: " + ", ".join(dict.fromkeys(_format_value(item, schema) for item in items))
        case _:
            text = f"{TYPES.get(found.get('type', ''), 'any')}{_format_bounds(found)}"
    return text


def _format_bounds(found: dict[str, Any]) -> str:
    low = _format_bound(found, "minimum", "from", "exclusiveMinimum", "above")
    high = _format_bound(found, "maximum", "to", "exclusiveMaximum", "below")
    return f", {' '.join(filter(None, (low, high)))}" if low or high else ""


def _format_bound(found: dict[str, Any], closed: str, closed_word: str, opened: str, opened_word: str) -> str:
    if closed in found:
        return f"{closed_word} {found[closed]:g}"
    return f"{opened_word} {found[opened]:g}" if opened in found else ""


def _format_default(model: type[BaseModel], key: str) -> str:
    field = model.model_fields[key]
    if field.is_required():
        return "**required**"
    match field.get_default(call_default_factory=True, validated_data={}):
        case None | () | "":
            return ""
        case BaseModel():
            return "its defaults"
        case {}:
            return ""
        case Enum() as default:
            text = default.value
        case bool() as default:
            text = str(default).lower()
        case tuple() as default:
            text = str(list(default))
        case float() as default:
            text = f"{default:g}"
        case default:
            text = _escape(str(default))
    return f"`{text}`"


def _describe(model: type[BaseModel], key: str) -> str:
    for owner in model.__mro__:
        if owner.__module__ != "builtins" and (text := read_docstrings(owner).get(key)):
            return _escape(text)
    return ""


@cache
def read_docstrings(owner: type | ModuleType) -> dict[str, str]:
    """Return the docstrings below the fields of a class, or below the constants of a module, by their names."""
    try:
        tree = ast.parse(inspect.cleandoc("\n" + inspect.getsource(owner)))
    except (OSError, SyntaxError, TypeError):
        return {}
    body = tree.body if isinstance(owner, ModuleType) else getattr(tree.body[0], "body", [])
    found = {}
    for field, text in pairwise(body):
        match field, text:
            case (
                ast.AnnAssign(target=ast.Name(id=name)) | ast.Assign(targets=[ast.Name(id=name)]),
                ast.Expr(value=ast.Constant(value=value)),
            ):
                found[name] = " ".join(str(value).split())
    return found


def _escape(text: str) -> str:
    return text.replace("``", "`").replace("|", "\\|").replace("[", "\\[").replace("<", "&lt;")

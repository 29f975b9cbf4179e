"""The public interface of this robotcore as data: what a release promises, to compare with later releases."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import click

from docs.generator.public_names import MODULES, is_defined_in_robotcore, list_public_names
from robotcore import errors
from robotcore.cli.main import robotcore as command_line
from robotcore.description import RobotDescription, WorldDescription
from robotcore.hal.device import Device
from robotcore.plugins import APPS, BACKENDS, DEVICES, FAULTS, KINDS, load_registered

ROOT = Path(__file__).parents[2]
SOURCES = ("robotcore", "drivers", "apps")
GROUPS = (APPS, BACKENDS, DEVICES, FAULTS, KINDS)


def describe_interface() -> dict[str, Any]:
    """Return the interface as JSON: mappings from a name to the names in it."""
    names = {
        f"{module}.{name}": getattr(import_module(module), name)
        for module in MODULES
        for name in list_public_names(module)
    }
    return {
        "commands": {" ".join(path): sorted(options) for path, options in _list_commands(command_line)},
        "errors": {
            each.__name__: [each.kind, getattr(each, "exit_status", None)]
            for each in vars(errors).values()
            if isinstance(each, type) and issubclass(each, errors.RobotcoreError)
        },
        "error_kinds": sorted(set(_list_error_kinds())),
        "names": {name: _list_parameters(value) for name, value in names.items()},
        "classes": {name: _list_members(value) for name, value in names.items() if isinstance(value, type)},
        "registered": {group: sorted({each.name for each in entry_points(group=group)}) for group in GROUPS},
        "robot_keys": list_keys(RobotDescription.model_json_schema()),
        "world_keys": list_keys(WorldDescription.model_json_schema()),
        "driver_settings": {
            name: sorted(load_registered("driver", DEVICES, name).model_fields)
            for name in sorted({each.name for each in entry_points(group=DEVICES)})
        },
    }


def list_keys(schema: Mapping[str, Any]) -> list[str]:
    """Return the keys of a file by the JSON schema of its model, such as ``devices[camera].mount.x_m``."""
    return sorted(set(_walk(schema, schema.get("$defs", {}), "")))


def _walk(schema: Mapping[str, Any], parts: Mapping[str, Any], path: str) -> Iterator[str]:
    if "$ref" in schema:
        yield from _walk(parts[schema["$ref"].rpartition("/")[2]], parts, path)
    for choices in ("anyOf", "oneOf", "allOf"):
        for each in schema.get(choices, ()):
            yield from _walk(each, parts, path)
    if "items" in schema:
        yield from _walk(schema["items"], parts, path)
    properties = schema.get("properties", {})
    tag = next((properties[name]["const"] for name in ("kind", "shape") if "const" in properties.get(name, {})), "")
    here = f"{path}[{tag}]" if tag else path
    for name, value in properties.items():
        key = f"{here}.{name}".lstrip(".")
        yield key
        yield from _walk(value, parts, key)


def _list_commands(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], list[str]]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command
        options = [option for each in command.params for option in (*each.opts, *each.secondary_opts)]
        yield (*path, name), options
        if isinstance(command, click.Group):
            yield from _list_commands(command, (*path, name))


def _list_error_kinds() -> Iterator[str]:
    """Yield each kind of an error or of a finding that the code names in a call."""
    for folder in SOURCES:
        for file in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.keyword) and node.arg == "kind" and isinstance(node.value, ast.Constant):
                    yield str(node.value.value)


def _list_parameters(value: Any) -> list[str]:
    """Return the names of the parameters of a function or a class; a parameter without a default ends in ``!``."""
    try:
        parameters = inspect.signature(value).parameters.values()
    except (TypeError, ValueError):
        return []
    required = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return [
        f"{each.name}!" if each.default is each.empty and each.kind in required else each.name for each in parameters
    ]


def _list_members(value: type) -> list[str]:
    """Return the public members of a class and, of a device, the hooks that a driver implements."""
    members = {
        name: member
        for base in reversed(value.__mro__)
        if is_defined_in_robotcore(base)
        for name, member in ({**vars(base).get("__annotations__", {}), **vars(base)}).items()
    }
    hooks = {
        name
        for name, member in members.items()
        if issubclass(value, Device) and name.startswith("_") and not name.startswith("__") and member.__doc__
    }
    return sorted({name for name in members if not name.startswith("_")} | hooks)

"""Descriptions from files: shipped ones by name, a user's own by path; every fault in one line."""

from __future__ import annotations

import sys
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from robotcore.description.base import Described
from robotcore.description.robot import RobotDescription
from robotcore.description.world import WorldDescription
from robotcore.errors import DescriptionError, UnknownNameError, UsageError, suggestion
from robotcore.registry import backend_names

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ModelT = TypeVar("ModelT", bound=Described)


def robot_names() -> list[str]:
    """Return the names of the robots that are shipped."""
    return _shipped_names("robots")


def world_names() -> list[str]:
    """Return the names of the worlds that are shipped."""
    return _shipped_names("worlds")


def load_robot(name_or_file: str) -> RobotDescription:
    """Return a shipped robot by name, or a user's own from a ``.toml`` file."""
    file, data = _read("robot", "robots", name_or_file)
    own = {name: data.pop(name) for name in backend_names() if isinstance(data.get(name), dict)}
    return _validated(RobotDescription, file, {**data, "backends": own} if own else data)


def load_world(name_or_file: str) -> WorldDescription:
    """Return a shipped world by name, or a user's own from a ``.toml`` file."""
    from robotcore.description.placement import require_room

    file, data = _read("world", "worlds", name_or_file)
    world = _validated(WorldDescription, file, data)
    require_room(world, file)
    return world


def first_fault(error: ValidationError) -> tuple[str, str]:
    """Return the key of the first fault of a model, dotted, and what is wrong with it."""
    fault = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in fault["loc"] if part not in _UNION_TAGS)
    message = fault["msg"].removeprefix("Value error, ")
    if fault["type"] not in ("missing", "extra_forbidden", "value_error") and _is_short(fault["input"]):
        message += f", got {fault['input']!r}"
    return key, message


_UNION_TAGS = {"motor", "encoder", "range_sensor", "camera", "display", "box", "cylinder"}


def _is_short(value: Any) -> bool:
    return isinstance(value, (str, int, float, bool)) and len(str(value)) <= 40


def _shipped_names(folder: str) -> list[str]:
    files = resources.files("robotcore.description").joinpath(folder).iterdir()
    return sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))


def _read(kind: str, folder: str, name_or_file: str) -> tuple[str, dict[str, Any]]:
    """Return what to call the file in messages, and its data."""
    if name_or_file.endswith(".toml") or "/" in name_or_file:
        path = Path(name_or_file)
        try:
            return name_or_file, _parsed(name_or_file, path.read_bytes())
        except OSError as error:
            raise UsageError(f"{name_or_file}: {error.strerror}. Name a {kind} file that can be read") from error
    names = _shipped_names(folder)
    if name_or_file not in names:
        raise UnknownNameError(kind, name_or_file, names)
    shipped = resources.files("robotcore.description").joinpath(folder, f"{name_or_file}.toml")
    return f"{name_or_file}.toml", _parsed(f"{name_or_file}.toml", shipped.read_bytes())


def _parsed(file: str, content: bytes) -> dict[str, Any]:
    try:
        return tomllib.loads(content.decode())
    except UnicodeDecodeError as error:
        raise DescriptionError(file, "", "it is not text", "A description is a TOML file in UTF-8") from error
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise DescriptionError(file, "", f"it is not TOML: {error}", "Mend that line") from error


def _validated(model: type[ModelT], file: str, data: dict[str, Any]) -> ModelT:
    try:
        return model.model_validate(data)
    except ValidationError as error:
        key, fault = first_fault(error)
        raise DescriptionError(file, key, fault, _remedy(model, error)) from error


def _remedy(model: type[Described], error: ValidationError) -> str:
    fault = error.errors(include_url=False)[0]
    if fault["type"] == "extra_forbidden":
        return f"Take the key out, or correct it. {suggestion(str(fault['loc'][-1]), _keys(model))}"
    if fault["type"] == "missing":
        return "Add the key"
    return "Correct the value"


def _keys(model: type[Described]) -> list[str]:
    """Return every key that occurs anywhere in a description of this kind."""
    schema = model.model_json_schema()
    parts = [schema, *schema.get("$defs", {}).values()]
    return sorted({key for part in parts for key in part.get("properties", {})})

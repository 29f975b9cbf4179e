"""An app's settings: the fields of its dataclass, checked by their types."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, get_type_hints

from pydantic import TypeAdapter, ValidationError

from robotcore.behaviour import Behaviour
from robotcore.description import first_fault
from robotcore.errors import UnknownNameError, UsageError


@dataclasses.dataclass(frozen=True)
class Setting:
    """A setting that an app has: its name, its type as it is written, its default."""

    name: str
    type: Any
    default: Any


def settings_of(app: type[Behaviour]) -> dict[str, Setting]:
    """Return what can be set on an app, by name."""
    if not dataclasses.is_dataclass(app):
        return {}
    hints = get_type_hints(app, include_extras=True)
    fields = [field for field in dataclasses.fields(app) if field.init]
    return {field.name: Setting(field.name, hints[field.name], field.default) for field in fields}


def configure(app: type[Behaviour], values: Mapping[str, Any]) -> Behaviour:
    """Return the app with these settings; UsageError says which one does not fit, and why."""
    known = settings_of(app)
    checked = {}
    for name, value in values.items():
        if name not in known:
            raise UnknownNameError("setting", name, list(known))
        checked[name] = _checked(known[name], value)
    return app(**checked)


def _checked(setting: Setting, value: Any) -> Any:
    try:
        return TypeAdapter(setting.type).validate_python(value)
    except ValidationError as error:
        _, fault = first_fault(error)
        raise UsageError(f"setting {setting.name}: {fault}; the default is {setting.default!r}") from error

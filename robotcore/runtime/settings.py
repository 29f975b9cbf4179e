"""An app's settings: the fields of its dataclass, checked by their types."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from typing import Annotated, Any, get_type_hints

import annotated_types
from pydantic import Field, TypeAdapter, ValidationError

from robotcore.description import first_mistake
from robotcore.errors import BehaviourError, RobotcoreError, UnknownNameError, UsageError
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.forks import end_forks

__all__ = ["Interval", "Positive"]

Interval = annotated_types.Interval
"""The bounds of a setting: ``Annotated[float, Interval(gt=0, le=0.3)]`` is above 0, and at most 0.3."""

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
"""The type of a setting that is a finite number above 0."""


@dataclasses.dataclass(frozen=True)
class Setting:
    """A setting of an app."""

    name: str
    type: Any
    """The type that the app's class declares."""
    default: Any
    """The default value. It is `dataclasses.MISSING` if there is none."""


def list_settings(app: type[Behaviour]) -> dict[str, Setting]:
    """Return the settings of an app, by name.

    Raises BehaviourError if the app's code raises an exception, for example in a default factory.
    """
    if not dataclasses.is_dataclass(app):
        return {}
    with _blame(app):
        hints = get_type_hints(app, include_extras=True)
        return {
            field.name: Setting(field.name, hints[field.name], _make_default(field))
            for field in dataclasses.fields(app)
            if field.init
        }


def list_changes(app: Behaviour) -> dict[str, Any]:
    """Return the settings of an instance of an app that differ from their defaults, by name.

    Raises BehaviourError if the app's code raises an exception.
    """
    if not dataclasses.is_dataclass(app):
        return {}
    with _blame(type(app)):
        return {
            field.name: value
            for field in dataclasses.fields(app)
            if field.init and _differs(value := getattr(app, field.name, None), _make_default(field))
        }


def _differs(value: object, default: object) -> bool:
    try:
        return type(value) is not type(default) or bool(value != default)
    except ValueError:  # arrays
        return repr(value) != repr(default)


def configure(app: type[Behaviour], values: Mapping[str, Any]) -> Behaviour:
    """Create an app from its class and its settings.

    values: the settings by name. A text is converted to the type of its setting.

    Raises UsageError if a setting is unknown, missing or of another type. Raises BehaviourError if the app's code
    raises.
    """
    known = list_settings(app)
    checked: dict[str, Any] = {}
    for name, value in values.items():
        if not dataclasses.is_dataclass(app):
            declaration = _declare(app, name) or f"{name}: float = 0.5"
            raise UsageError(
                f"unknown setting {name!r}: {app.__name__} is no dataclass, so it has no settings. "
                f"Put @dataclass above it, and declare the setting with its type, such as {declaration}",
                kind="not-a-dataclass",
            )
        if name not in known:
            if declaration := _declare(app, name):
                raise UsageError(
                    f"{name!r} is no setting of {app.__name__}, because it has no type. Write {declaration}",
                    kind="setting-without-type",
                    setting=name,
                )
            raise UnknownNameError("setting", name, list(known))
        checked[name] = _convert(known[name], value)
    for setting in known.values():
        if setting.default is dataclasses.MISSING and setting.name not in checked:
            raise UsageError(
                f"the app needs the setting {setting.name}. Add --set {setting.name}=VALUE",
                kind="setting-missing",
                setting=setting.name,
            )
    with _blame(app):
        return app(**checked)


@contextmanager
def _blame(app: type[Behaviour]) -> Iterator[None]:
    """Raise BehaviourError for an exception of the app's code, and end a copy of the process that this code makes."""
    try:
        with end_forks(f"the creation of {app.__name__}"):
            yield
    except RobotcoreError:
        raise
    except (Exception, SystemExit) as error:
        raise BehaviourError.from_exception(app, error) from error


def _make_default(field: dataclasses.Field[Any]) -> Any:
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()


def _declare(app: type[Behaviour], name: str) -> str:
    """Return the declaration of a setting for a plain attribute of an app's class. Empty if there is none."""
    value = getattr(app, name, None)
    is_declared = hasattr(Behaviour, name) or name in getattr(app, "__dataclass_fields__", ())
    is_value = isinstance(value, (bool, int, float, str)) and not is_declared
    return f"{name}: {type(value).__name__} = {value!r}" if is_value else ""


def _convert(setting: Setting, value: Any) -> Any:
    try:
        return TypeAdapter(setting.type).validate_python(value)
    except ValidationError as error:
        _, problem = first_mistake(error)
        default = setting.default.value if isinstance(setting.default, Enum) else setting.default
        hint = "" if default is dataclasses.MISSING else f"; the default is {default!r}"
        raise UsageError(
            f"setting {setting.name}: {problem}{hint}",
            kind="setting-invalid",
            setting=setting.name,
        ) from error

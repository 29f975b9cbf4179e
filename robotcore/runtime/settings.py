"""An app's settings: the fields of its dataclass, checked by their types."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, get_type_hints

from annotated_types import Interval as Interval  # noqa: PLC0414  given on
from pydantic import Field, TypeAdapter, ValidationError

from robotcore.description import first_mistake
from robotcore.errors import BehaviourError, RobotcoreError, UnknownNameError, UsageError
from robotcore.runtime.behaviour import Behaviour

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
"""The type of a setting that is a finite number above 0."""


@dataclasses.dataclass(frozen=True)
class Setting:
    """A setting that an app has: its name, its type as it is written, its default."""

    name: str
    type: Any
    default: Any


def settings_of(app: type[Behaviour]) -> dict[str, Setting]:
    """Return what can be set on an app, by name.

    Raises BehaviourError where its own code raises: a type that is not there, or what makes a default.
    """
    if not dataclasses.is_dataclass(app):
        return {}
    try:
        hints = get_type_hints(app, include_extras=True)
        fields = [field for field in dataclasses.fields(app) if field.init]
        return {field.name: Setting(field.name, hints[field.name], _default_of(field)) for field in fields}
    except RobotcoreError:
        raise
    except (Exception, SystemExit) as error:
        raise BehaviourError.raised_by(app, error) from error


def configure(app: type[Behaviour], values: Mapping[str, Any]) -> Behaviour:
    """Return the app with these settings; UsageError says which one does not fit, and why.

    Raises BehaviourError where the app's own code raises.
    """
    known = settings_of(app)
    checked = {}
    for name, value in values.items():
        if name not in known:
            raise _unknown(app, name, list(known))
        checked[name] = _checked(known[name], value)
    for setting in known.values():
        if setting.default is dataclasses.MISSING and setting.name not in checked:
            raise UsageError(f"the app needs the setting {setting.name}; give it: --set {setting.name}=VALUE")
    try:
        return app(**checked)
    except RobotcoreError:
        raise
    except (Exception, SystemExit) as error:
        raise BehaviourError.raised_by(app, error) from error


def _default_of(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _unknown(app: type[Behaviour], name: str, known: list[str]) -> UsageError:
    if known or dataclasses.is_dataclass(app):
        return UnknownNameError("setting", name, known)
    return UsageError(
        f"unknown setting {name!r}: {app.__name__} is no dataclass. Put @dataclass above it; its fields are settings"
    )


def _checked(setting: Setting, value: Any) -> Any:
    try:
        return TypeAdapter(setting.type).validate_python(value)
    except ValidationError as error:
        _, fault = first_mistake(error)
        raise UsageError(f"setting {setting.name}: {fault}; the default is {setting.default!r}") from error

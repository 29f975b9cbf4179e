"""The kinds of value that options take."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from robotcore.errors import UsageError


class Folder(click.Path):
    """A folder by its name; an empty one, such as a variable of the shell's that nobody has set, is none."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, file_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not str(value):
            self.fail("the name is empty. Name a folder, or leave the option out", param, ctx)
        return super().convert(value, param, ctx)


def pair(value: str) -> tuple[str, str]:
    """Return ``KEY=VALUE`` as a tuple of the two; only the first ``=`` parts them."""
    key, _, what = (part.strip() for part in value.partition("="))
    if not key or "=" not in value:
        raise click.BadParameter(f"{value!r} is not KEY=VALUE")
    return key, what


def count(value: str) -> int:
    """Return a whole number from 1 on."""
    if not value.strip().isdecimal() or not int(value):
        raise click.BadParameter(f"{value!r} is no count; take a whole number from 1 on")
    return int(value)


def size(value: str) -> int:
    """Return a size in bytes, from 1 on: ``500MB``, ``1.5 GiB``, ``4096``."""
    from pydantic import ByteSize, TypeAdapter, ValidationError

    try:
        found = TypeAdapter(ByteSize).validate_python(value.strip())
    except ValidationError:
        found = ByteSize(0)
    if found < 1:
        raise click.BadParameter(f"{value!r} is no size; take one such as 500MB or 2GB")
    return int(found)


def names(value: str) -> tuple[str, ...]:
    """Return the names between commas, in order, each once."""
    found = tuple(dict.fromkeys(name for part in value.split(",") if (name := part.strip())))
    if not found:
        raise click.BadParameter("name one or more, separated by commas")
    return found


def faults(_context: click.Context, _parameter: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    """Return specs of faults in their canonical form, those of a file in its place."""
    if not values:
        return ()
    from robotcore.runtime.faults.spec import specs_in

    try:
        return specs_in(values)
    except UsageError as error:
        raise click.BadParameter(str(error)) from error

"""A run as the words that repeat it, and as a line for a shell."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from typing import Any

from robotcore.runtime.plan import RunRequest

_OPTIONS = {
    "rate_hz": "--rate",
    "timeout_s": "--timeout",
    "settings": "--set",
    "options": "--option",
    "faults": "--fault",
}
"""The options that are not called what the field of the request is called."""


def command_of(request: RunRequest) -> str:
    """Return ``robotcore run …`` with every option that is not the default, quoted."""
    return shlex.join(["robotcore", "run", request.app, *words_of(request)])


def words_of(request: RunRequest) -> list[str]:
    """Return the options of ``robotcore run`` that are not the default, word by word."""
    return [word for name, value in _asked(request) for word in _words(_OPTIONS.get(name, f"--{name}"), value)]


def _asked(request: RunRequest) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a request that are not what they are by default."""
    for each in fields(request):
        default = each.default if each.default_factory is MISSING else each.default_factory()
        if each.name != "app" and (value := getattr(request, each.name)) != default:
            yield each.name, value


def _words(option: str, value: Any) -> Iterator[str]:
    if value is True:
        yield option
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from (option, f"{key}={item}")
    elif isinstance(value, tuple):
        for item in value:
            yield from (option, item)
    else:
        yield from (option, repr(value).removesuffix(".0") if isinstance(value, float) else str(value))

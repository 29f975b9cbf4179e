"""``sweep.json``: what the results in a folder depend on, and which seeds were asked for last."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from robotcore.errors import UsageError
from robotcore.sweep.fingerprint import Parts
from robotcore.sweep.replacing import replacing

SPEC = "sweep.json"

_MOST = 4
"""So many differences are told."""


def manifest(parts: Parts, seeds: str) -> str:
    """Return what the file of a sweep tells."""
    return json.dumps({**parts, "seeds": seeds}, indent=2) + "\n"


def write_manifest(directory: Path, told: str) -> None:
    """Write the file."""
    with replacing(directory / SPEC) as file:
        file.write(told)


def require_same(directory: Path, parts: Parts) -> None:
    """Raise UsageError, with what has changed, where the results in a folder depend on something else."""
    try:
        then = json.loads((directory / SPEC).read_text(encoding="utf-8"))
        changed = [] if {name: then[name] for name in parts} == parts else _told(parts, then)
    except (ValueError, KeyError, TypeError, AttributeError):
        changed = [f"its {SPEC} cannot be read"]
    if changed:
        more = f"; and {len(changed) - _MOST} more" if len(changed) > _MOST else ""
        raise UsageError(
            f"{directory} holds other results: {'; '.join(changed[:_MOST])}{more}. "
            "Name another folder with --out, or run it anew with --fresh"
        )


def _told(now: Parts, then: Parts) -> list[str]:
    """Return what has changed, in words; where something else was asked for, that alone."""
    return _differences("asked", now, then) or [
        words for name in now if name != "asked" for words in _differences(name, now, then)
    ]


def _differences(name: str, now: Parts, then: Parts) -> list[str]:
    return [_WORDS[name](key, is_, was) for key, is_, was in _changed(now[name], then[name])]


def _changed(now: dict[str, Any], then: dict[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    """Yield each key with what it is and what it was, None where it is not there."""
    for key in dict.fromkeys([*now, *then]):
        if now.get(key) != then.get(key):
            yield key, now.get(key), then.get(key)


def _value(key: str, is_: Any, was: Any) -> str:
    is_, was = (
        "not given" if each is None else each if isinstance(each, str) else json.dumps(each) for each in (is_, was)
    )
    return f"{key} is {is_}, was {was}"


def _code(package: str, is_: Any, was: Any) -> str:
    return f"the code of {package} {_deed(is_, was)}"


def _file(file: str, is_: Any, was: Any) -> str:
    path = Path(file)
    shown = path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
    return f"your file {shown} {_deed(is_, was)}"


def _version(library: str, is_: Any, was: Any) -> str:
    return f"{library} is {is_ or 'not there'}, was {was or 'not there'}"


def _deed(is_: Any, was: Any) -> str:
    return "has changed" if is_ and was else "is new" if is_ else "is gone"


_WORDS: dict[str, Callable[[str, Any, Any], str]] = {
    "asked": _value,
    "code": _code,
    "files": _file,
    "libraries": _version,
}

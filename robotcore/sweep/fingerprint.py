"""What the results of a sweep depend on: the request, the code, the user's files, the libraries."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

from robotcore.description import is_own
from robotcore.errors import UsageError
from robotcore.hal.backend import load_backend
from robotcore.runtime.apps import app_path, is_app_file, load_app
from robotcore.runtime.faults.planning import modules_of
from robotcore.runtime.versions import libraries
from robotcore.sweep.durable import replace_text
from robotcore.sweep.spec import Sweep

Dependencies = dict[str, dict[str, Any]]

_SOURCES = {".py", ".toml"}
_DRIVERS = "drivers"
_REPORT = "robotcore/sweep/report"
"""Made from results; a change in it changes none."""

MANIFEST = "sweep.json"

_MAX_CHANGES = 4
"""The most differences in an error's text."""


def collect_dependencies(sweep: Sweep) -> Dependencies:
    """Return everything that could change a result, ready for JSON: ``asked``, ``code``, ``files``, ``libraries``.

    The seeds do not count: no run depends on another. Code and files are listed by their digests.
    """
    found = {
        "asked": _flatten_request(sweep),
        "code": _code_digests(sweep.apps, sweep.backends, sweep.request.faults),
        "files": {str(file): _sha256(content) for file, content in read_own_files(sweep).items()},
        "libraries": libraries(sweep.backends),
    }
    ready: Dependencies = json.loads(json.dumps(found, sort_keys=True, default=str))
    return ready


def compute_digest(dependencies: Dependencies) -> str:
    """Return a digest of what `collect_dependencies` returned."""
    return _sha256(json.dumps(dependencies, sort_keys=True).encode())


def code_digest(apps: Iterable[str], backends: Iterable[str], faults: Iterable[str]) -> str:
    """Return a digest of the sources of robotcore, of the backends and faults, and of those apps that have a name."""
    return _sha256("".join(_code_digests(apps, backends, faults).values()).encode())


def _flatten_request(sweep: Sweep) -> dict[str, Any]:
    """Return what was asked for, each setting and option by itself; the order of backends and worlds does not count."""
    request: dict[str, Any] = {name: ", ".join(sorted(getattr(sweep, name))) for name in ("backends", "worlds")}
    for name, value in asdict(sweep.request).items():
        if isinstance(value, Mapping):
            request |= {f"{name}.{key}": each for key, each in value.items()}
        elif name not in ("backend", "world", "seed"):
            request[name] = value
    return request


def _code_digests(apps: Iterable[str], backends: Iterable[str], faults: Iterable[str]) -> dict[str, str]:
    """Return the digests of packages by their names, in the order of these.

    Whole packages count: a line that changes nothing is taken for one that might. Of robotcore's own drivers each is
    a package by itself: none knows another.
    """
    modules = [type(load_backend(backend)).__module__ for backend in backends]
    modules += [load_app(app).__module__ for app in apps if not is_app_file(app)]
    packages = {"robotcore", *map(_find_package, [*modules, *modules_of(faults)])}
    return {package: _package_digest(package) for package in sorted(packages)}


def _find_package(module: str) -> str:
    """Return the outermost package of a module, or the folder of a driver in ours."""
    names = module.split(".")
    return ".".join(names[: 2 if names[0] == _DRIVERS else 1])


@cache
def _package_digest(name: str) -> str:
    """Return a digest of a package's sources as they were when this process looked first, soon after importing it."""
    total = hashlib.sha256()
    for file, name_there in sorted(_list_sources(name), key=lambda source: source[1]):
        total.update(f"{name_there} {_sha256(file.read_bytes())}\n".encode())
    return total.hexdigest()


def _list_sources(name: str) -> Iterator[tuple[Path, str]]:
    """Yield the source files of a package, or of a module that stands alone, and what they are called in it."""
    module = sys.modules[name]
    for root in map(Path, getattr(module, "__path__", ())):
        for file in root.rglob("*"):
            there = f"{name}/{file.relative_to(root)}"
            if file.suffix in _SOURCES and not there.startswith(_REPORT):
                yield file, there
    if not hasattr(module, "__path__") and module.__file__:
        yield Path(module.__file__), name


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def read_own_files(sweep: Sweep) -> dict[Path, bytes]:
    """Return the files by their absolute paths, in order, with what is in them."""
    return {file: _read_content(file) for file in sorted(set(_list_own_files(sweep)))}


def _list_own_files(sweep: Sweep) -> Iterator[Path]:
    for name in filter(is_app_file, sweep.apps):
        app = app_path(name).absolute()
        yield from (app, *filter(_is_module, app.parent.glob("*.py")))
    yield from (Path(name).absolute() for name in (sweep.request.robot, *sweep.worlds) if is_own(name))


def _is_module(file: Path) -> bool:
    """Return whether it can be imported; the lock of an editor (``.#app.py``) or a folder cannot."""
    return file.is_file() and not file.name.startswith(".")


def _read_content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise UsageError(
            f"{file}: {error.strerror}. Name a file that can be read", kind="unreadable-file", file=str(file)
        ) from error


def format_manifest(dependencies: Dependencies, seeds: str) -> str:
    """Return the content of ``sweep.json``."""
    return json.dumps({**dependencies, "seeds": seeds}, indent=2) + "\n"


def write_manifest(directory: Path, content: str) -> None:
    """Write ``sweep.json``."""
    with replace_text(directory / MANIFEST) as file:
        file.write(content)


def require_same(directory: Path, dependencies: Dependencies) -> None:
    """Raise UsageError, with the changes, if the results in a folder depend on something else."""
    try:
        then = json.loads((directory / MANIFEST).read_text(encoding="utf-8"))
        changed = (
            [] if {name: then[name] for name in dependencies} == dependencies else _describe_changes(dependencies, then)
        )
    except (ValueError, KeyError, TypeError, AttributeError):
        changed = [f"its {MANIFEST} cannot be read"]
    if changed:
        more = f"; and {len(changed) - _MAX_CHANGES} more" if len(changed) > _MAX_CHANGES else ""
        raise UsageError(
            f"{directory} holds other results: {'; '.join(changed[:_MAX_CHANGES])}{more}. "
            "Name another folder with --out, or run it anew with --fresh",
            kind="other-results",
            directory=str(directory),
            changes=changed,
        )


def _describe_changes(now: Dependencies, then: Dependencies) -> list[str]:
    """Describe the changes; if the request differs, only the changes of the request."""
    return _describe_part("asked", now, then) or [
        words for name in now if name != "asked" for words in _describe_part(name, now, then)
    ]


def _describe_part(name: str, now: Dependencies, then: Dependencies) -> list[str]:
    return [_DESCRIBERS[name](key, is_, was) for key, is_, was in _list_changes(now[name], then[name])]


def _list_changes(now: dict[str, Any], then: dict[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    """Yield each key with what it is and what it was, None where it is not there."""
    for key in dict.fromkeys([*now, *then]):
        if now.get(key) != then.get(key):
            yield key, now.get(key), then.get(key)


def _describe_value(key: str, is_: Any, was: Any) -> str:
    is_, was = (
        "not given" if each is None else each if isinstance(each, str) else json.dumps(each) for each in (is_, was)
    )
    return f"{key} is {is_}, was {was}"


def _describe_code(package: str, is_: Any, was: Any) -> str:
    return f"the code of {package} {_describe_change(is_, was)}"


def _describe_file(file: str, is_: Any, was: Any) -> str:
    path = Path(file)
    shown = path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
    return f"your file {shown} {_describe_change(is_, was)}"


def _describe_version(library: str, is_: Any, was: Any) -> str:
    return f"{library} is {is_ or 'not there'}, was {was or 'not there'}"


def _describe_change(is_: Any, was: Any) -> str:
    return "has changed" if is_ and was else "is new" if is_ else "is gone"


_DESCRIBERS: dict[str, Callable[[str, Any, Any], str]] = {
    "asked": _describe_value,
    "code": _describe_code,
    "files": _describe_file,
    "libraries": _describe_version,
}

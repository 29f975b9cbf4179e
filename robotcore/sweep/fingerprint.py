"""The fingerprint of a sweep: its request, digests of code and files, and versions of libraries."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

from robotcore.description import find_floor_image, is_own
from robotcore.errors import UsageError
from robotcore.hal.backend import load_backend
from robotcore.runtime.apps import app_path, is_app_file, load_app
from robotcore.runtime.faults.planning import list_modules
from robotcore.runtime.versions import libraries
from robotcore.sweep.spec import Sweep

Dependencies = dict[str, dict[str, Any]]
"""Everything that the results of a sweep depend on: the content of ``sweep.json`` without the seeds."""

_SOURCES = {".py", ".toml"}
_DRIVERS = "drivers"
_REPORT = "robotcore/sweep/report"
"""The folder whose code is not part of the fingerprint. The code of reports cannot change results."""

MANIFEST = "sweep.json"
"""The name of the file in a results folder that lists what the results depend on."""

_MAX_CHANGES = 4
"""The maximum number of changes in an error message."""


def collect_dependencies(sweep: Sweep) -> Dependencies:
    """Return everything that the results of a sweep depend on, as JSON values.

    The key ``asked`` has the request, ``code`` the digests of packages by name, ``files`` the digests of the user's
    files by path, and ``libraries`` the versions by name. The seeds are left out: the result of a run does not depend
    on the other seeds of its sweep.
    """
    found = {
        "asked": _flatten_request(sweep),
        "code": compute_code_digests(sweep.apps, sweep.backends, sweep.request.faults),
        "files": {str(file): _sha256(content) for file, content in read_own_files(sweep).items()},
        "libraries": libraries(sweep.backends),
    }
    ready: Dependencies = json.loads(json.dumps(found, sort_keys=True, default=str))
    return ready


def compute_digest(dependencies: Dependencies) -> str:
    """Return the SHA-256 digest of everything that the results of a sweep depend on."""
    return _sha256(json.dumps(dependencies, sort_keys=True).encode())


def _flatten_request(sweep: Sweep) -> dict[str, Any]:
    """Return the request as a dict with a key for each setting and option. Backends and worlds are sorted."""
    request: dict[str, Any] = {name: ", ".join(sorted(getattr(sweep, name))) for name in ("backends", "worlds")}
    for name, value in asdict(sweep.request).items():
        if isinstance(value, Mapping):
            request |= {f"{name}.{key}": each for key, each in value.items()}
        elif name not in ("backend", "world", "seed"):
            request[name] = value
    return request


def compute_code_digests(apps: Iterable[str], backends: Iterable[str], faults: Iterable[str]) -> dict[str, str]:
    """Return the digests of robotcore and of the packages of the backends, the faults and the installed apps, by name.

    A change in any line of a package changes its digest, even if the line has no effect on results. Each driver of
    this project has its own digest. No driver imports another, so a change in one cannot affect runs on the others.
    """
    modules = [type(load_backend(backend)).__module__ for backend in backends]
    modules += [load_app(app).__module__ for app in apps if not is_app_file(app)]
    packages = {"robotcore", *map(_find_package, [*modules, *list_modules(faults)])}
    return {package: _compute_package_digest(package) for package in sorted(packages)}


def _find_package(module: str) -> str:
    """Return the outermost package of a module. For a driver of this project, return the driver's own package."""
    names = module.split(".")
    return ".".join(names[: 2 if names[0] == _DRIVERS else 1])


@cache
def _compute_package_digest(name: str) -> str:
    """Return the digest of a package's sources.

    The result is cached. The process has imported the package, so later changes of its sources do not affect runs.
    """
    total = hashlib.sha256()
    for file, key in sorted(_list_sources(name), key=lambda source: source[1]):
        total.update(f"{key} {_sha256(file.read_bytes())}\n".encode())
    return total.hexdigest()


def _list_sources(name: str) -> Iterator[tuple[Path, str]]:
    """Yield the source files of a package or module, each with its path relative to the package's parent folder."""
    module = sys.modules[name]
    for root in map(Path, getattr(module, "__path__", ())):
        for file in root.rglob("*"):
            key = f"{name}/{file.relative_to(root).as_posix()}"
            if file.suffix in _SOURCES and not key.startswith(_REPORT):
                yield file, key
    if not hasattr(module, "__path__") and module.__file__:
        yield Path(module.__file__), name


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def read_own_files(sweep: Sweep) -> dict[Path, bytes]:
    """Return the contents of the user's files by their absolute paths, sorted.

    These are the files of the app and the judge, all modules beside them, the descriptions of the robot and the worlds,
    those that an option of the backend names, and the pictures on the floors. Raises UsageError if a file cannot be
    read.
    """
    contents = {}
    for file in sorted(set(_list_own_files(sweep))):
        try:
            contents[file] = file.read_bytes()
        except OSError as error:  # noqa: PERF203  few files
            raise UsageError(
                f"{file}: {error.strerror}. Name a readable file", kind="unreadable-file", file=str(file)
            ) from error
    return contents


def _list_own_files(sweep: Sweep) -> Iterator[Path]:
    for name in filter(is_app_file, sweep.apps):
        app = app_path(name).absolute()
        yield app
        # A folder, and the lock file of an editor, .#app.py, cannot be imported.
        yield from (each for each in app.parent.glob("*.py") if each.is_file() and not each.name.startswith("."))
    worlds = [name for name in sweep.worlds if is_own(name)]
    options = (str(value) for value in sweep.request.options.values())
    descriptions = (sweep.request.robot, *worlds, *(each for each in options if each.endswith(".toml")))
    yield from (Path(name).absolute() for name in descriptions if is_own(name))
    yield from (picture.absolute() for picture in map(find_floor_image, worlds) if picture)


def format_manifest(dependencies: Dependencies, seeds: str) -> str:
    """Return the content of ``sweep.json``.

    seeds: the seeds of the sweep, as `format_seeds` writes them.
    """
    return json.dumps({**dependencies, "seeds": seeds}, indent=2) + "\n"


def require_same(directory: Path, dependencies: Dependencies) -> None:
    """Raise UsageError if the folder's ``sweep.json`` differs from ``dependencies``.

    The field ``changes`` of the error lists the differences.
    """
    try:
        changes = _describe_changes(dependencies, json.loads((directory / MANIFEST).read_text(encoding="utf-8")))
    except (ValueError, KeyError, TypeError, AttributeError):
        changes = [f"its {MANIFEST} cannot be read"]
    if changes:
        more = f"; and {len(changes) - _MAX_CHANGES} more" if len(changes) > _MAX_CHANGES else ""
        raise UsageError(
            f"{directory} has the results of another sweep: {'; '.join(changes[:_MAX_CHANGES])}{more}. "
            "Name another folder with --out, or delete these results with --fresh",
            kind="other-results",
            directory=str(directory),
            changes=changes,
        )


def _describe_changes(now: Dependencies, then: Dependencies) -> list[str]:
    """Return a text for each change from ``then`` to ``now``. If the request changed, return only its changes."""
    changes = {
        part: [
            (key, now[part].get(key), then[part].get(key))
            for key in dict.fromkeys([*now[part], *then[part]])
            if now[part].get(key) != then[part].get(key)
        ]
        for part in now
    }
    if asked := changes.pop("asked"):
        return [f"{key} changed from {_format_value(old)} to {_format_value(new)}" for key, new, old in asked]
    return [
        f"{key} changed from {old or 'not installed'} to {new or 'not installed'}"
        if part == "libraries"
        else f"{_SUBJECTS[part]} {_shorten_path(key)} {'is new' if not old else 'has changed' if new else 'is gone'}"
        for part, differing in changes.items()
        for key, new, old in differing
    ]


_SUBJECTS = {"code": "the code of", "files": "your file"}


def _format_value(value: Any) -> str:
    return "not given" if value is None else value if isinstance(value, str) else json.dumps(value)


def _shorten_path(name: str) -> str:
    """Return a path relative to the working directory if it is below it. Other names stay unchanged."""
    path = Path(name)
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)

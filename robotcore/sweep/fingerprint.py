"""What the results of a sweep depend on: what was asked, the code, the user's files, the libraries."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

from robotcore.hal.backend import load_backend
from robotcore.runtime.apps import is_app_file, load_app
from robotcore.runtime.faults.catalogue import modules_of
from robotcore.runtime.versions import libraries
from robotcore.sweep.ownfiles import own_files
from robotcore.sweep.spec import Sweep

Parts = dict[str, dict[str, Any]]

_SOURCES = {".py", ".toml"}
_DRIVERS = "drivers"
_PAGE = "robotcore/sweep/report"
"""Made from results; a change in it changes none."""


def parts(sweep: Sweep) -> Parts:
    """Return everything that could change a result, ready for JSON: ``asked``, ``code``, ``files``, ``libraries``.

    The seeds do not count: a run knows nothing of the others. Code and files are told by their digests.
    """
    told = {
        "asked": _asked(sweep),
        "code": _code_digests(sweep.apps, sweep.backends, sweep.request.faults),
        "files": {str(file): _sha256(content) for file, content in own_files(sweep).items()},
        "libraries": libraries(sweep.backends),
    }
    ready: Parts = json.loads(json.dumps(told, sort_keys=True, default=str))
    return ready


def digest(told: Parts) -> str:
    """Return a digest of what `parts` told."""
    return _sha256(json.dumps(told, sort_keys=True).encode())


def code_digest(apps: Iterable[str], backends: Iterable[str], faults: Iterable[str]) -> str:
    """Return a digest of the sources of robotcore, of the backends and faults, and of those apps that have a name."""
    return _sha256("".join(_code_digests(apps, backends, faults).values()).encode())


def _asked(sweep: Sweep) -> dict[str, Any]:
    """Return what was asked for, each setting and option by itself; in which order backends and worlds, is all one."""
    told: dict[str, Any] = {name: ", ".join(sorted(getattr(sweep, name))) for name in ("backends", "worlds")}
    for name, value in asdict(sweep.request).items():
        if isinstance(value, Mapping):
            told |= {f"{name}.{key}": each for key, each in value.items()}
        elif name not in ("backend", "world", "seed"):
            told[name] = value
    return told


def _code_digests(apps: Iterable[str], backends: Iterable[str], faults: Iterable[str]) -> dict[str, str]:
    """Return the digests of packages by their names, in the order of these.

    Whole packages count: a line that changes nothing is taken for one that might. Of robotcore's own drivers each is
    a package by itself: none knows another.
    """
    modules = [type(load_backend(backend)).__module__ for backend in backends]
    modules += [load_app(app).__module__ for app in apps if not is_app_file(app)]
    packages = {"robotcore", *map(_package, [*modules, *modules_of(faults)])}
    return {package: _package_digest(package) for package in sorted(packages)}


def _package(module: str) -> str:
    """Return the outermost package of a module, or the folder of a driver in ours."""
    names = module.split(".")
    return ".".join(names[: 2 if names[0] == _DRIVERS else 1])


@cache
def _package_digest(name: str) -> str:
    """Return a digest of a package's sources as they were when this process looked first, soon after importing it."""
    total = hashlib.sha256()
    for file, name_there in sorted(_sources(name), key=lambda source: source[1]):
        total.update(f"{name_there} {_sha256(file.read_bytes())}\n".encode())
    return total.hexdigest()


def _sources(name: str) -> Iterator[tuple[Path, str]]:
    """Yield the source files of a package, or of a module that stands alone, and what they are called in it."""
    module = sys.modules[name]
    for root in map(Path, getattr(module, "__path__", ())):
        for file in root.rglob("*"):
            there = f"{name}/{file.relative_to(root)}"
            if file.suffix in _SOURCES and not there.startswith(_PAGE):
                yield file, there
    if not hasattr(module, "__path__") and module.__file__:
        yield Path(module.__file__), name


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

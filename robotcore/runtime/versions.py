"""The versions of what computes: results and recordings name them."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version

from robotcore.hal.backend import load_backend

LIBRARIES = ("numpy", "cv2")
PYTHON = "python"


def libraries(backends: Iterable[str]) -> dict[str, str]:
    """Return the versions of Python and of the libraries that compute, by the names that pip knows."""
    modules = {*LIBRARIES, *(module for backend in backends for module in load_backend(backend).modules)}
    found = {PYTHON: platform.python_version()}
    for name in {module.partition(".")[0] for module in modules}:
        for owner in _owners().get(name, (name,)):  # Python 3.10 knows some owners only by the module's name
            with suppress(PackageNotFoundError):
                found[owner] = version(owner)
    return dict(sorted(found.items()))


@cache
def _owners() -> Mapping[str, list[str]]:
    """Return who brought each module; it takes long, and what is imported by now stays as it is."""
    return packages_distributions()

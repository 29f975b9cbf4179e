"""The versions of Python and of the libraries that influence a result. Results and recordings contain them."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version

from robotcore.hal.backend import load_backend

LIBRARIES = ("numpy", "cv2")
"""The modules of the libraries that influence a result on every backend."""
PYTHON = "python"


def libraries(backends: Iterable[str]) -> dict[str, str]:
    """Return the versions of Python and of the libraries that influence a result, by their names in pip.

    backends: the names of the backends whose libraries are included.
    """
    modules = {*LIBRARIES, *(module for backend in backends for module in load_backend(backend).modules)}
    found = {PYTHON: platform.python_version()}
    for name in {module.partition(".")[0] for module in modules}:
        for owner in _find_distributions().get(name, (name,)):  # Python 3.10 finds no distribution for some modules
            with suppress(PackageNotFoundError):
                found[owner] = version(owner)
    return dict(sorted(found.items()))


@cache
def _find_distributions() -> Mapping[str, list[str]]:
    return packages_distributions()

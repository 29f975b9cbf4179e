"""Check the packages that every backend needs: Python, NumPy and OpenCV.

This module imports NumPy and OpenCV only in their checks, so that a broken library becomes a finding.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator

from robotcore.hal.check_finding import Check, Finding

OLDEST, NEWEST = (3, 10), (3, 13)
"""The oldest and the newest version of Python with which robotcore is tested."""


def machine_checks() -> tuple[tuple[str, Check], ...]:
    """Return the checks that apply to every machine, by name."""
    return (("Python", python), ("NumPy", numpy), ("OpenCV", opencv))


def python() -> Iterator[Finding]:
    """Check whether robotcore is tested with this Python."""
    version = f"{platform.python_version()} in {sys.prefix}"
    if OLDEST <= sys.version_info[:2] <= NEWEST:
        yield Finding.ok("Python", version, kind="python-tested")
    else:
        tested = " to ".join(f"{major}.{minor}" for major, minor in (OLDEST, NEWEST))
        yield Finding.warning(
            "Python", f"{version}; robotcore is not tested with it", f"Use Python {tested}", kind="python-untested"
        )


def numpy() -> Iterator[Finding]:
    """Check whether NumPy can be imported and computes correctly."""
    try:
        import numpy as np

        total = int(np.arange(4).sum())
    except Exception as error:  # noqa: BLE001  an incompatible build of a library may raise any exception
        yield _broken("NumPy", error, "pip install --force-reinstall 'numpy>=1.24'")
    else:
        assert total == 6, total
        yield Finding.ok("NumPy", np.__version__, kind="numpy-works")


def opencv() -> Iterator[Finding]:
    """Check whether OpenCV can be imported and works with this NumPy."""
    try:
        import cv2
        import numpy as np

        cv2.cvtColor(np.zeros((2, 2, 3), np.uint8), cv2.COLOR_BGR2GRAY)
    except Exception as error:  # noqa: BLE001  an incompatible build of a library may raise any exception
        remedy = "pip install --force-reinstall opencv-python-headless; on a Pi: sudo apt install python3-opencv"
        yield _broken("OpenCV", error, remedy)
    else:
        yield Finding.ok("OpenCV", cv2.__version__, kind="opencv-works")


def _broken(what: str, error: Exception, remedy: str) -> Finding:
    text = " ".join(str(error).split())
    return Finding.error(what, f"does not work: {type(error).__name__}: {text}", remedy, kind="library-broken")

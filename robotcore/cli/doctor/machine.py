"""Check what every backend needs: Python, NumPy and OpenCV.

This module imports NumPy and OpenCV only inside their checks. So a broken library becomes a finding, not an exception.
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
    return (("Python", check_python), ("NumPy", check_numpy), ("OpenCV", check_opencv))


def check_python() -> Iterator[Finding]:
    """Yield whether robotcore is tested with this version of Python."""
    version = f"{platform.python_version()} in {sys.prefix}"
    if OLDEST <= sys.version_info[:2] <= NEWEST:
        yield Finding.ok("Python", version, kind="python-tested")
    else:
        tested = " to ".join(f"{major}.{minor}" for major, minor in (OLDEST, NEWEST))
        yield Finding.warning(
            "Python",
            f"{version}: robotcore is not tested with this version",
            f"Use Python {tested}",
            kind="python-untested",
        )


def check_numpy() -> Iterator[Finding]:
    """Yield whether NumPy can be imported and computes correctly."""
    try:
        import numpy as np

        total = int(np.arange(4).sum())
    except Exception as error:  # noqa: BLE001  an incompatible build of a library may raise any exception
        yield _broken("NumPy", error, "pip install --force-reinstall 'numpy>=1.24'")
    else:
        assert total == 6, total
        yield Finding.ok("NumPy", np.__version__, kind="numpy-works")


def check_opencv() -> Iterator[Finding]:
    """Yield whether OpenCV can be imported and works with the installed NumPy."""
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

"""What every backend leans on: Python, NumPy, OpenCV."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator

from robotcore.hal.finding import Check, Finding

OLDEST, NEWEST = (3, 10), (3, 13)
"""Of Python, between which everything is tested."""


def machine_checks() -> tuple[tuple[str, Check], ...]:
    """Return the checks of any machine; none of them imports anything before it is made."""
    return (("Python", python), ("NumPy", numpy), ("OpenCV", opencv))


def python() -> Iterator[Finding]:
    """Look whether this Python is one of those that are tested."""
    said = f"{platform.python_version()} in {sys.prefix}"
    if OLDEST <= sys.version_info[:2] <= NEWEST:
        yield Finding.ok("Python", said)
    else:
        tested = " to ".join(f"{major}.{minor}" for major, minor in (OLDEST, NEWEST))
        yield Finding.warning("Python", f"{said}, with which nothing is tested", f"Take Python {tested}")


def numpy() -> Iterator[Finding]:
    """Look whether NumPy can be imported and computes."""
    try:
        import numpy as np

        total = int(np.arange(4).sum())
    except Exception as error:  # noqa: BLE001  a library of another build raises anything
        yield _broken("NumPy", error, "pip install --force-reinstall 'numpy>=1.24'")
    else:
        assert total == 6, total
        yield Finding.ok("NumPy", np.__version__)


def opencv() -> Iterator[Finding]:
    """Look whether OpenCV can be imported, and was built for this NumPy."""
    try:
        import cv2
        import numpy as np

        cv2.cvtColor(np.zeros((2, 2, 3), np.uint8), cv2.COLOR_BGR2GRAY)
    except Exception as error:  # noqa: BLE001  a library of another build raises anything
        remedy = "pip install --force-reinstall opencv-python-headless; on a Pi: sudo apt install python3-opencv"
        yield _broken("OpenCV", error, remedy)
    else:
        yield Finding.ok("OpenCV", cv2.__version__)


def _broken(what: str, error: Exception, remedy: str) -> Finding:
    text = " ".join(str(error).split())
    return Finding.error(what, f"does not work: {type(error).__name__}: {text}", remedy)

"""Check what every backend needs: Python, NumPy and OpenCV.

A function that runs a library imports it. So a broken library becomes a finding, not an exception.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Iterator
from functools import partial

from robotcore.hal.check_finding import Check, Finding
from robotcore.python_versions import MAX_PYTHON, MIN_PYTHON
from robotcore.system import IS_LINUX


def check_python() -> Iterator[Finding]:
    """Yield whether robotcore is tested with this version of Python."""
    version = f"{platform.python_version()} in {sys.prefix}"
    if MIN_PYTHON <= sys.version_info[:2] <= MAX_PYTHON:
        yield Finding.ok("Python", version, kind="python-tested")
    else:
        tested = " to ".join(f"{major}.{minor}" for major, minor in (MIN_PYTHON, MAX_PYTHON))
        yield Finding.warning(
            "Python",
            f"{version}: robotcore is not tested with this version",
            f"Use Python {tested}",
            kind="python-untested",
        )


def check_system() -> Iterator[Finding]:
    """Yield a warning on another system than Linux, because robotcore has not run there."""
    if not IS_LINUX:
        yield Finding.warning(
            "system",
            f"{platform.system()}: robotcore has run on Linux only, and some protections of a run need Linux",
            'The page "Operating systems" of the documentation lists the features that this system lacks',
            kind="system-untested",
        )


def check_processor() -> Iterator[Finding]:
    """Yield a warning for a Python of 32 bits, also if the kernel has 64 bits."""
    if sys.maxsize < 2**32:
        yield Finding.warning(
            "Processor",
            f"this Python has 32 bits, on {platform.machine()}: robotcore is not tested with it, and some libraries "
            "have no wheels for it",
            "Install the 64-bit Raspberry Pi OS, which a Pi 3, 4, 5 and Zero 2 W can run",
            kind="processor-untested",
        )


def check_library(name: str, run: Callable[[], str], remedy: str) -> Iterator[Finding]:
    """Yield whether a library can be imported and works.

    run: a function that uses the library, and returns its version.
    """
    try:
        yield Finding.ok(name, run(), kind=f"{name.lower()}-works")
    except Exception as error:  # noqa: BLE001  an incompatible build of a library may raise any exception
        text = " ".join(str(error).split())
        yield Finding.error(name, f"does not work: {type(error).__name__}: {text}", remedy, kind="library-broken")


def _run_numpy() -> str:
    import numpy as np

    assert int(np.arange(4).sum()) == 6
    return np.__version__


def _run_opencv() -> str:
    import cv2
    import numpy as np

    cv2.cvtColor(np.zeros((2, 2, 3), np.uint8), cv2.COLOR_BGR2GRAY)
    return cv2.__version__


def list_machine_checks() -> tuple[tuple[str, Check], ...]:
    """Return the checks that apply to every machine, by name."""
    opencv = "pip install --force-reinstall opencv-python-headless; on a Pi: sudo apt install python3-opencv"
    return (
        ("system", check_system),
        ("Python", check_python),
        ("Processor", check_processor),
        ("NumPy", partial(check_library, "NumPy", _run_numpy, "pip install --force-reinstall 'numpy>=1.24'")),
        ("OpenCV", partial(check_library, "OpenCV", _run_opencv, opencv)),
    )

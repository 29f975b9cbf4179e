"""Which library drives the pins, and whether it can."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version

from drivers.raspberrypi.pins import open_pins
from robotcore.errors import BackendError, UsageError
from robotcore.hal.finding import Finding

WHAT = "pin factory"
EMPTY_STUB = "0.0.0.2"
"""The only lgpio that pip has ready built for Python 3.13 on a Pi: nothing is in it, and it hides apt's in a venv."""

OLDEST_GPIOZERO = (2, 0, 1)
"""As the extra ``pi`` asks for."""


def library() -> Iterator[Finding]:
    """Look whether the library that a run takes is there and gets at the pins; no pin is touched."""
    if installed("lgpio") == EMPTY_STUB:
        remedy = "pip uninstall lgpio; sudo apt install python3-lgpio, and a venv made with --system-site-packages"
        yield Finding.error(WHAT, f"lgpio {EMPTY_STUB} is an empty stub", remedy)
        return
    gpiozero = installed("gpiozero") or "0"
    if _numbers(gpiozero) < OLDEST_GPIOZERO:
        yield Finding.error(WHAT, f"gpiozero {gpiozero} is too old", "pip install --upgrade 'gpiozero>=2.0.1'")
    try:
        open_pins().close()
    except (BackendError, UsageError) as error:
        fault, _, remedy = str(error).partition(". ")
        yield Finding.error(WHAT, fault, remedy)
    else:
        yield Finding.ok(WHAT, f"lgpio {installed('lgpio') or ''}".strip() + f", under gpiozero {gpiozero}")


def installed(package: str) -> str | None:
    """Return the version of a package that is installed; None where it is not."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split(".")[:3] if part.isdecimal())

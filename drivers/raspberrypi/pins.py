"""The pin factory: gpiozero's own on a named library, never another one in silence."""

from __future__ import annotations

import os
import tempfile
from typing import TYPE_CHECKING

from robotcore.errors import BackendError, BackendMissingError, UnknownNameError

if TYPE_CHECKING:
    from gpiozero import Factory

LIBRARIES = ("lgpio", "rpigpio", "pigpio", "native", "mock")
DEFAULT = "lgpio"
FIFO_FOLDER = "LG_WD"
"""Where lgpio makes its FIFO, by default the working directory; it cannot be imported where that is read-only.
Source: https://github.com/gpiozero/gpiozero/issues/1106."""


def open_pins(library: str | None) -> Factory:
    """Return gpiozero's pin factory on the library of that name, by default what gpiozero's own setting names.

    Raises BackendMissingError where the library is not installed, BackendError where it cannot get at the pins.
    """
    name = library or os.environ.get("GPIOZERO_PIN_FACTORY") or DEFAULT
    if name not in LIBRARIES:
        raise UnknownNameError("pin factory", name, LIBRARIES)
    os.environ.setdefault(FIFO_FOLDER, tempfile.gettempdir())
    try:
        return _made(name)
    except ImportError as error:
        raise BackendMissingError(f"the pin factory {name!r} is not installed ({error}). {_REMEDIES[name]}") from error
    except Exception as error:
        raise BackendError(f"the pin factory {name!r} cannot get at the pins: {error}. {_GENERAL}") from error


def _made(name: str) -> Factory:
    match name:
        case "lgpio":
            from gpiozero.pins.lgpio import LGPIOFactory

            return LGPIOFactory()
        case "rpigpio":
            from gpiozero.pins.rpigpio import RPiGPIOFactory

            return RPiGPIOFactory()
        case "pigpio":
            from gpiozero.pins.pigpio import PiGPIOFactory

            return PiGPIOFactory()
        case "native":
            from gpiozero.pins.native import NativeFactory

            return NativeFactory()
    from gpiozero.pins.mock import MockFactory, MockPWMPin

    return MockFactory(pin_class=MockPWMPin)


_GENERAL = "Run robotcore doctor on the robot; at the desk, --backend virtualpi needs no pins"
_REMEDIES = {
    "lgpio": "On the Pi: sudo apt install python3-lgpio, and a venv made with --system-site-packages",
    "rpigpio": "pip install RPi.GPIO; not on a Pi 5, which has lgpio only",
    "pigpio": "pip install pigpio, and start its daemon: sudo systemctl start pigpiod; not on a Pi 5",
    "native": "Take lgpio instead",
    "mock": "pip install gpiozero",
}

"""The pin factory: gpiozero's own on lgpio, never another one in silence."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from drivers.raspberrypi.chip import AT_THE_DESK, why_closed
from drivers.raspberrypi.lg import chip_number, load
from robotcore.errors import BackendError, BackendMissingError, UnknownNameError, UsageError

if TYPE_CHECKING:
    from gpiozero import Factory

LGPIO = "lgpio"
OTHERS = ("rpigpio", "pigpio", "native", "mock")
"""What gpiozero has besides. The first three go past the kernel, which then knows of no holder of a line."""

_SETTING = "GPIOZERO_PIN_FACTORY"


def open_pins(library: str | None = None) -> Factory:
    """Return gpiozero's pin factory on lgpio; its ``close`` frees every line.

    Raises UsageError where another library is asked for, here or by gpiozero's own setting: no other process could take
    its lines and stop the motors. Raises BackendMissingError where lgpio is not installed, BackendError where it cannot
    get at the pins.
    """
    name = library or os.environ.get(_SETTING) or LGPIO
    if name in OTHERS:
        raise UsageError(
            f"pin factory {name!r}: nobody could stop its motors when this program cannot. Take lgpio: "
            f"--option pin_factory=lgpio, or unset {_SETTING}. {AT_THE_DESK}"
        )
    if name != LGPIO:
        raise UnknownNameError("pin factory", name, [LGPIO])
    _require_board()
    try:
        return _on_lgpio()
    except ImportError as error:
        raise BackendMissingError(f"lgpio cannot be used: {error}. {_REMEDY}") from error


def _require_board() -> None:
    """Raise BackendError where this is no Raspberry Pi: before a library, which elsewhere nobody needs."""
    from gpiozero.exc import PinUnknownPi
    from gpiozero.pins.local import get_pi_revision

    try:
        get_pi_revision()
    except PinUnknownPi as error:
        raise BackendError(f"this is no Raspberry Pi ({error}). {AT_THE_DESK}") from error


def _on_lgpio() -> Factory:
    lgpio = load()
    from gpiozero.pins.lgpio import LGPIOFactory

    try:
        return LGPIOFactory(chip_number())  # the guardian's too: lines of one number on two chips are different lines
    except lgpio.error as error:
        raise BackendError(why_closed(chip_number())) from error


_REMEDY = f"On the Pi: sudo apt install python3-lgpio, and a venv made with --system-site-packages. {AT_THE_DESK}"

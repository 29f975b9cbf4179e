"""The pin factory (gpiozero's own on lgpio, never another one), and the errors of its pins as errors of a device."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Event
from typing import TYPE_CHECKING

from drivers.raspberrypi.chip import AT_THE_DESK, explain_closed_chip, find_holder
from drivers.raspberrypi.lg import chip_number, load
from robotcore.errors import (
    BackendError,
    BackendMissingError,
    DeviceError,
    RobotcoreError,
    UnknownNameError,
    UsageError,
)

if TYPE_CHECKING:
    from gpiozero import Factory, Pin


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
            f"--option pin_factory=lgpio, or unset {_SETTING}. {AT_THE_DESK}",
            kind="pin-factory-unsafe",
            pin_factory=name,
        )
    if name != LGPIO:
        raise UnknownNameError("pin factory", name, [LGPIO])
    _require_board()
    try:
        return _on_lgpio()
    except ImportError as error:
        raise BackendMissingError(f"lgpio cannot be used: {error}. {_REMEDY}", kind="lgpio-missing") from error


def _require_board() -> None:
    """Raise BackendError where this is no Raspberry Pi: before a library, which elsewhere nobody needs."""
    from gpiozero.exc import PinUnknownPi
    from gpiozero.pins.local import get_pi_revision

    try:
        get_pi_revision()
    except PinUnknownPi as error:
        raise BackendError(f"this is no Raspberry Pi ({error}). {AT_THE_DESK}", kind="no-raspberry-pi") from error


def _on_lgpio() -> Factory:
    lgpio = load()
    from gpiozero.pins.lgpio import LGPIOFactory

    try:
        return LGPIOFactory(chip_number())  # the guardian's too: lines of one number on two chips are different lines
    except lgpio.error as error:
        raise BackendError(explain_closed_chip(chip_number()), kind="gpio-chip-closed") from error


_REMEDY = f"On the Pi: sudo apt install python3-lgpio, and a venv made with --system-site-packages. {AT_THE_DESK}"


@contextmanager
def translate_pin_errors(device: str, gpios: Sequence[int]) -> Iterator[None]:
    """Open what a device has on these GPIOs; where that fails, raise DeviceError, with what to do.

    Claim them one by one where they are to be told apart: the libraries do not say which one it was.
    """
    try:
        yield
    except RobotcoreError:
        raise
    except Exception as error:
        raise build_pin_error(device, gpios, error) from error


def build_pin_error(device: str, gpios: Sequence[int], error: Exception) -> DeviceError:
    """Return the error for what gpiozero or lgpio raised at the pins of a device.

    The two have no error in common, and lgpio's (``'GPIO busy'``) tells of its kind in words only.
    """
    from gpiozero import GPIOPinInUse

    where = "GPIO " + ", ".join(map(str, gpios))
    if isinstance(error, GPIOPinInUse):
        return DeviceError(
            device,
            f"{where} is in use in this program already. Close what has it first",
            kind="gpio-in-use",
            gpios=tuple(gpios),
        )
    if "busy" in str(error).lower():
        held = ", ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in gpios)
        return DeviceError(device, f"{held}. End that program first", kind="gpio-held", gpios=tuple(gpios))
    cause = f"{type(error).__name__}: {error}".removesuffix(": ")
    return DeviceError(
        device,
        f"{where} failed ({cause}). Look at the wiring in the robot's file, and run robotcore doctor",
        kind="gpio-failed",
        gpios=tuple(gpios),
    )


_STOP_ATTEMPTS = 100
_STOP_PAUSE_S = 0.01


def stop_edge_detection(pin: Pin) -> None:
    """Tell nobody of a pin's edges from now on.

    lgpio frees the line and claims it anew. Where its own thread is just waiting for edges, the kernel lets the line go
    only when that is back, and until then it is busy. Raises what the library raises where that goes on for a second.
    """
    for _ in range(_STOP_ATTEMPTS):
        if _try_stop(pin):
            return
        Event().wait(_STOP_PAUSE_S)
    pin.when_changed = None


def _try_stop(pin: Pin) -> bool:
    try:
        pin.when_changed = None
    except Exception as error:
        if "busy" not in str(error).lower():
            raise
        return False
    return True

"""Open gpiozero's pin factory on lgpio, and translate errors of its pins to DeviceErrors."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Event
from typing import TYPE_CHECKING

from drivers.raspberrypi.chip import AT_THE_DESK, explain_closed_chip, find_holder
from drivers.raspberrypi.lg import find_chip_number, load
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
"""The names of gpiozero's other pin libraries. The first three bypass the kernel, so the kernel cannot report which
process holds a line. The last one simulates pins."""

_SETTING = "GPIOZERO_PIN_FACTORY"


def open_pins(library: str | None = None) -> Factory:
    """Return gpiozero's pin factory on lgpio. Its ``close`` frees every line.

    Raises UsageError for any other library, because then the guardian could not stop the motors of an app that hangs.
    Raises BackendMissingError if lgpio is not installed, and BackendError if this user cannot open the pins.

    library: the name of the library; by default the value of GPIOZERO_PIN_FACTORY, else lgpio.
    """
    name = library or os.environ.get(_SETTING) or LGPIO
    if name in OTHERS:
        raise UsageError(
            f"pin factory {name!r}: the guardian could not stop the motors if this program hangs. Use lgpio: "
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
        return LGPIOFactory(find_chip_number())  # the guardian uses the same number
    except lgpio.error as error:
        raise BackendError(explain_closed_chip(find_chip_number()), kind="gpio-chip-closed") from error


_REMEDY = f"On the Pi: sudo apt install python3-lgpio, and a venv made with --system-site-packages. {AT_THE_DESK}"


@contextmanager
def translate_pin_errors(device: str, gpios: Sequence[int]) -> Iterator[None]:
    """Translate errors of gpiozero and lgpio in the block to DeviceErrors.

    The errors of the libraries do not name the GPIO. So the block should use only one GPIO.

    device: the name of the device, for the error.
    gpios: the GPIOs that the block uses, for the error.
    """
    try:
        yield
    except RobotcoreError:
        raise
    except Exception as error:
        raise build_pin_error(device, gpios, error) from error


def build_pin_error(device: str, gpios: Sequence[int], error: Exception) -> DeviceError:
    """Return the DeviceError with a remedy for an error of gpiozero or lgpio.

    device: the name of the device.
    gpios: the GPIOs of the device that the failed call used.
    """
    # The two libraries share no error class, and lgpio has only a text such as 'GPIO busy'.
    from gpiozero import GPIOPinInUse

    where = "GPIO " + ", ".join(map(str, gpios))
    if isinstance(error, GPIOPinInUse):
        return DeviceError(
            device,
            f"{where} is already in use in this program. Close the device that uses it first",
            kind="gpio-in-use",
            gpios=tuple(gpios),
        )
    if "busy" in str(error).lower():
        held = ", ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in gpios)
        return DeviceError(device, f"{held}. End that program first", kind="gpio-held", gpios=tuple(gpios))
    cause = f"{type(error).__name__}: {error}".removesuffix(": ")
    return DeviceError(
        device,
        f"{where} failed ({cause}). Check the wiring in the robot's file, and run robotcore doctor",
        kind="gpio-failed",
        gpios=tuple(gpios),
    )


_STOP_ATTEMPTS = 100
_STOP_PAUSE_S = 0.01


def stop_edge_detection(pin: Pin) -> None:
    """Stop gpiozero's callbacks for the edges of a pin; raises lgpio's error if that fails for a second.

    lgpio frees the line and claims it again without edge detection. The claim fails until lgpio's own thread returns
    from its wait for edges. So it is tried several times.
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

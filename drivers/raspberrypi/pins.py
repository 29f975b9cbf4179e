"""Open gpiozero's pin factory on lgpio, and translate errors of its pins to DeviceErrors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Event
from traceback import clear_frames
from typing import TYPE_CHECKING

from drivers.raspberrypi.chip import AT_THE_DESK, INSTALL, explain_closed_chip, find_chip_number, find_holder, load
from robotcore.errors import BackendError, BackendMissingError, DeviceError, RobotcoreError

if TYPE_CHECKING:
    from gpiozero import Factory, Pin


def open_pins() -> Factory:
    """Return gpiozero's pin factory on lgpio. Its ``close`` frees every line.

    GPIOZERO_PIN_FACTORY has no effect: the lines of other libraries are not the kernel's, so the guardian could not
    stop the motors of an app that hangs.

    Raises BackendMissingError if lgpio is not installed, and BackendError if this user cannot open the pins.
    """
    from gpiozero.exc import PinUnknownPi
    from gpiozero.pins.local import get_pi_revision

    try:
        get_pi_revision()
    except PinUnknownPi as error:
        raise BackendError(f"this is no Raspberry Pi ({error}). {AT_THE_DESK}", kind="no-raspberry-pi") from error
    try:
        lgpio = load()
        from gpiozero.pins.lgpio import LGPIOFactory
    except ImportError as error:
        raise BackendMissingError(f"lgpio cannot be used: {error}. {INSTALL}", kind="lgpio-missing") from error
    number = find_chip_number()
    try:
        return LGPIOFactory(number)  # the guardian uses the same number
    except lgpio.error as error:
        raise BackendError(explain_closed_chip(number), kind="gpio-chip-closed") from error


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
        clear_frames(error.__traceback__)  # they refer to gpiozero's failed device, which would keep its GPIO reserved
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
        kind = "gpio-in-use"
        problem = f"{where} is already in use in this program. Close the device that uses it first"
    elif "busy" in str(error).lower():
        kind = "gpio-held"
        held = ", ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in gpios)
        problem = f"{held}. End that program first"
    else:
        kind, cause = "gpio-failed", f"{type(error).__name__}: {error}".removesuffix(": ")
        problem = f"{where} failed ({cause}). Check the wiring in the robot's file, and run robotcore doctor"
    return DeviceError(device, problem, kind=kind, gpios=tuple(gpios))


_STOP_ATTEMPTS = 100
_STOP_PAUSE_S = 0.01


def stop_edge_detection(pin: Pin) -> None:
    """Stop gpiozero's callbacks for the edges of a pin; raises lgpio's error if that fails for a second.

    lgpio frees the line and claims it again without edge detection. The claim fails until lgpio's own thread returns
    from its wait for edges. So it is tried several times.
    """
    for _ in range(_STOP_ATTEMPTS):
        try:
            pin.when_changed = None
        except Exception as error:  # noqa: PERF203  the claim is tried again
            if "busy" not in str(error).lower():
                raise
            Event().wait(_STOP_PAUSE_S)
        else:
            return
    pin.when_changed = None

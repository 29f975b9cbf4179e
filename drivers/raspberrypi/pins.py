"""Open gpiozero's pin factory on lgpio and its outputs, and translate errors of its pins to DeviceErrors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from threading import Event
from traceback import clear_frames
from typing import TYPE_CHECKING

from drivers.raspberrypi.chip import AT_THE_DESK, INSTALL, explain_closed_chip, find_chip_number, find_holder, load
from robotcore.errors import BackendError, BackendMissingError, DeviceError, RobotcoreError

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, Factory, Pin, PWMOutputDevice


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
        factory = LGPIOFactory(number)  # the guardian uses the same number
    except lgpio.error as error:
        raise BackendError(explain_closed_chip(number), kind="gpio-chip-closed") from error
    factory.pin_class = _define_pin_class()
    return factory


def _define_pin_class() -> type[Pin]:
    from gpiozero.pins.lgpio import LGPIOPin

    class LateEdgePin(LGPIOPin):  # type: ignore[misc]  # gpiozero has no types
        """A pin that ignores an edge if its detection has just been stopped.

        The callback of LGPIOPin raises TypeError then. It would end the one thread in which lgpio reports edges, and no
        device of this program would get an edge again.
        """

        def _call_when_changed(self, chip: int, gpio: int, level: int, ticks: int) -> None:
            with self._when_changed_lock:  # gpiozero holds it while it stops the detection
                function = self.when_changed
            if function:
                function(ticks / 1e9, level)

    return LateEdgePin


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
        problem = f"{where} is already in use in this program. Close the robot or the device that uses it first"
    elif "busy" in str(error).lower():
        kind = "gpio-held"
        held = ", ".join(f"GPIO {gpio} is held by {find_holder(gpio)}" for gpio in gpios)
        problem = f"{held}. End that program first"
    else:
        kind, cause = "gpio-failed", f"{type(error).__name__}: {error}".removesuffix(": ")
        problem = f"{where} failed ({cause}). Check the wiring in the robot's file, and run robotcore doctor"
    return DeviceError(device, problem, kind=kind, gpios=tuple(gpios))


PWM_HZ = 100
"""The frequency of a light's PWM. A person sees no flicker at it."""


def open_output(
    device: str,
    number: int,
    pins: Factory,
    opened: ExitStack,
    *,
    frequency_hz: int | None = None,
    is_high: bool = False,
    active_high: bool = True,
) -> PWMOutputDevice | DigitalOutputDevice:
    """Open a GPIO as an output, and return it; raises DeviceError. The duty of a GPIO with PWM is 0 at first.

    device: the device's name, for errors.
    opened: the stack whose `close` frees the GPIO and pulls it to the level of the duty 0.
    frequency_hz: the frequency of the PWM; None means no PWM.
    is_high: the first level of a GPIO without PWM.
    active_high: whether the duty is the share of the time for which the GPIO is high. Else it is low for this time.
    """
    from gpiozero import DigitalOutputDevice, PWMOutputDevice

    with translate_pin_errors(device, (number,)):
        if frequency_hz is None:
            output = DigitalOutputDevice(number, initial_value=is_high, pin_factory=pins)
        else:
            output = PWMOutputDevice(number, active_high=active_high, frequency=frequency_hz, pin_factory=pins)
        opened.callback(_pull, device, number, pins, "down" if active_high else "up")
        return opened.enter_context(output)


def _pull(device: str, number: int, pins: Factory, direction: str) -> None:
    # gpiozero leaves a closed GPIO floating until the Pi starts again. A board without resistors, such as an L298N's,
    # and a transistor read a floating input as high or as noise.
    from gpiozero import PinFixedPull

    with (
        translate_pin_errors(device, (number,)),
        suppress(PinFixedPull),
    ):  # GPIO 2 and 3 have resistors to 3.3 V on the Pi
        pins.pin(number).pull = direction


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

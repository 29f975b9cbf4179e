"""The one place where errors of the pins' libraries become errors of a device."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from drivers.raspberrypi.holders import held_by
from robotcore.errors import DeviceError, RobotcoreError


@contextmanager
def claiming(device: str, gpios: Sequence[int]) -> Iterator[None]:
    """Open what a device has on these GPIOs; where that fails, raise DeviceError, with what to do.

    Claim them one by one where they are to be told apart: the libraries do not say which one it was.
    """
    try:
        yield
    except RobotcoreError:
        raise
    except Exception as error:
        raise pin_failure(device, gpios, error) from error


def pin_failure(device: str, gpios: Sequence[int], error: Exception) -> DeviceError:
    """Return the error for what gpiozero or lgpio raised at the pins of a device.

    The two have no error in common, and lgpio's (``'GPIO busy'``) tells of its kind in words only.
    """
    from gpiozero import GPIOPinInUse

    where = "GPIO " + ", ".join(map(str, gpios))
    if isinstance(error, GPIOPinInUse):
        return DeviceError(device, f"{where} is in use in this program already. Close what has it first")
    if "busy" in str(error).lower():
        held = ", ".join(f"GPIO {gpio} is held by {held_by(gpio)}" for gpio in gpios)
        return DeviceError(device, f"{held}. End that program first")
    cause = f"{type(error).__name__}: {error}".removesuffix(": ")
    return DeviceError(
        device, f"{where} failed ({cause}). Look at the wiring in the robot's file, and run robotcore doctor"
    )

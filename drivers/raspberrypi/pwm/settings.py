"""The settings of a PCA9685 that the drivers of its motors and servos share, and the open chip."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Annotated, ClassVar

from pydantic import Field

from drivers.raspberrypi.i2c import Address, BusDriver, build_no_answer_error, build_no_bus_error, format_place
from drivers.raspberrypi.i2c_device import I2CDevice, ReservedChipError, find_bus
from drivers.raspberrypi.pwm.chip import ExternalClockError, PwmChip, Registers, ResetError, WrongChipError
from robotcore.errors import DeviceError, Mistake
from robotcore.hardware import Connection, DeviceContext, Drivers

CHIP = "PCA9685"

Channel = Annotated[int, Field(ge=0, le=15, description="the number of a channel of the chip, 0 to 15")]
"""The type of a channel in a robot's file."""

SUPPLY = "Connect the chip's VCC to 3.3 V, and its ground to a ground pad, once for the chip. A HAT needs no wires."
"""The note that `robotcore wiring` prints for a device on the chip."""

GROUP_REMEDY = "Run sudo usermod -aG i2c $USER, then log out and in again"
OVERLAY_REMEDY = "Remove its overlay, such as i2c-pwm-pca9685a, from /boot/firmware/config.txt, and restart"


@contextmanager
def translate_chip_errors(device: str, bus: int, address: int) -> Iterator[None]:
    """Translate an OSError in the block to a DeviceError with a remedy."""
    where = f"I2C {format_place(bus, address)}"
    try:
        yield
    except DeviceError:
        raise
    except FileNotFoundError as error:
        raise build_no_bus_error(device, bus) from error
    except ReservedChipError as error:
        message = f"another run uses the {CHIP} at {where}. End it first: robotcore stop"
        raise DeviceError(device, message, kind="chip-held") from error
    except PermissionError as error:
        message = f"no permission for {find_bus(bus)}. {GROUP_REMEDY}"
        raise DeviceError(device, message, kind="no-permission-i2c") from error
    except ResetError as error:
        message = f"the {CHIP} at {where} was reset, and its outputs are off. Check its 3.3 V, and the motors' supply"
        raise DeviceError(device, message, kind="chip-reset") from error
    except ExternalClockError as error:
        message = f"a program has set the {CHIP} at {where} to an external clock. Switch its 3.3 V off and on"
        raise DeviceError(device, message, kind="external-clock") from error
    except WrongChipError as error:
        listed = f"i2cdetect -y {bus} lists the chips that answer"
        message = f"the chip at {where} is no {CHIP}: {error}. Correct address or bus: {listed}"
        raise DeviceError(device, message, kind="wrong-chip") from error
    except OSError as error:
        if error.errno == errno.EBUSY:
            message = f"a driver of the kernel uses {where}. {OVERLAY_REMEDY}"
            raise DeviceError(device, message, kind="chip-in-kernel") from error
        raise build_no_answer_error(device, bus, address, error.strerror or error) from error


class SharedChip(PwmChip):
    """A chip whose `close` raises DeviceError in place of OSError.

    device: the device that opened the chip, for errors.
    """

    def __init__(self, registers: Registers, device: str, bus: int, address: int) -> None:
        super().__init__(registers)
        self._device, self._bus, self._address = device, bus, address

    def close(self) -> None:
        with translate_chip_errors(self._device, self._bus, self._address):
            super().close()


class ChannelDriver(BusDriver):
    """The base class of the drivers of devices on channels of a PCA9685."""

    shared_chip = CHIP
    supply: ClassVar[tuple[str, ...]] = ()  # one supply for all devices on the chip: see `SUPPLY`

    address: Address = 0x40
    """The 7-bit address of the chip on the bus."""

    @property
    def wanted_hz(self) -> int:
        """The frequency of the chip's PWM that the device needs, in Hz."""
        raise NotImplementedError

    def connect(self, signal: str, number: int) -> Connection:
        """Return the connection of a device's ``signal`` to a channel."""
        return Connection(signal, CHIP, f"channel {number} of {self.place}")

    def require_one_frequency(self, drivers: Drivers) -> None:
        """Raise Mistake if this is the first device on its chip that needs another frequency of the PWM."""
        earlier: dict[str, int] = {}
        for name, other in drivers.items():
            if other is self:
                break
            if isinstance(other, ChannelDriver) and other.place == self.place:
                earlier[name] = other.wanted_hz
        if len({*earlier.values()}) == 1 and self.wanted_hz not in earlier.values():
            name, hz = next(iter(earlier.items()))
            problem = (
                f"needs a PWM of {self.wanted_hz} Hz, but {name} on the same {CHIP} needs {hz} Hz, "
                "and all channels of a chip have one frequency"
            )
            remedy = "Set frequency_hz of its motors to one value, and to 50 if it has servos"
            raise Mistake(problem, remedy, kind="frequency-conflict")

    def take_chip(self, device: str, context: DeviceContext) -> PwmChip:
        """Return the open chip, which devices share; raises DeviceError. Every channel of a new one is off."""

        def open_chip() -> PwmChip:
            with ExitStack() as undo:
                registers = self._open_registers(context)
                undo.callback(registers.close)
                chip = SharedChip(registers, device, self.bus, self.address)
                chip.begin(self.wanted_hz)
                undo.pop_all()
            return chip

        with self.translate_errors(device):
            return context.shared.take(PwmChip, (self.bus, self.address), open_chip)

    @contextmanager
    def translate_errors(self, device: str) -> Iterator[None]:
        """Translate an OSError in the block to a DeviceError with a remedy."""
        with translate_chip_errors(device, self.bus, self.address):
            yield

    def _open_registers(self, context: DeviceContext) -> Registers:
        if is_virtual(context):
            registers: Registers = context.pins.open_i2c(self.bus, self.address)
            return registers
        device = I2CDevice(find_bus(self.bus), self.address)
        try:
            device.reserve()
        except BaseException:
            device.close()
            raise
        return device


def is_virtual(context: DeviceContext) -> bool:
    """Return whether the robot's pins have a simulated I2C bus."""
    return hasattr(context.pins, "open_i2c")

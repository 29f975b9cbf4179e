"""The base classes of the drivers of chips on an I2C bus."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Annotated, Any, ClassVar

from pydantic import Field

from drivers.raspberrypi.header import HEADER_BUS, gpio
from drivers.raspberrypi.i2c_device import find_bus
from robotcore.errors import DeviceError
from robotcore.hardware import Connection, DeviceDriver

Address = Annotated[int, Field(ge=0x08, le=0x77)]


HEADER_BUS_REMEDY = (
    "Run sudo raspi-config nonint do_i2c 0, or add dtparam=i2c_arm=on to /boot/firmware/config.txt. Then restart"
)
OTHER_BUS_REMEDY = (
    "Add dtoverlay=i2c{bus} to /boot/firmware/config.txt and restart; /boot/firmware/overlays/README lists its pins"
)


def explain_switch_on(bus: int) -> str:
    """Return how to switch an I2C bus on."""
    return HEADER_BUS_REMEDY if bus == HEADER_BUS else OTHER_BUS_REMEDY.format(bus=bus)


def format_place(bus: int, address: int) -> str:
    """Return the place of a chip, such as ``0x40 on bus 1``."""
    return f"0x{address:02x} on bus {bus}"


def build_no_bus_error(device: str, bus: int) -> DeviceError:
    """Return the error for a bus that is switched off. The caller raises it from the exception."""
    return DeviceError(device, f"there is no {find_bus(bus)}. {explain_switch_on(bus)}", kind="i2c-off")


def build_no_answer_error(device: str, bus: int, address: int, cause: object) -> DeviceError:
    """Return the error for a chip that does not answer. The caller raises it from the exception."""
    message = (
        f"no answer at I2C {format_place(bus, address)} ({cause}). i2cdetect -y {bus} lists the chips that answer. "
        "Check SDA, SCL, 3.3 V, ground, address and driver"
    )
    return DeviceError(device, message, kind="chip-unanswered")


class TransactionLimit:
    """An I2C bus that raises TimeoutError after ``left`` transactions.

    It ends the waits of Adafruit's libraries that have no time limit.
    """

    def __init__(self, bus: Any, left: float) -> None:
        self._bus, self.left = bus, left

    def try_lock(self) -> bool:
        """Begin a transaction; raises TimeoutError at the limit."""
        if self.left <= 0:
            raise TimeoutError("the chip does not measure")
        self.left -= 1
        return bool(self._bus.try_lock())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)


class BusDriver(DeviceDriver):
    """The base class of the drivers of chips on an I2C bus, with the settings of the connection."""

    supply: ClassVar[tuple[str, ...]] = ("3.3 V", "ground")
    shared_chip: ClassVar[str] = ""
    """The name of a chip that several devices share. Only devices with the same name may have the same address."""

    bus: Annotated[int, Field(ge=0, le=30)] = HEADER_BUS
    """The number of the chip's I2C bus."""

    address: Address
    """The 7-bit address of the chip on the bus."""

    @property
    def place(self) -> str:
        return format_place(self.bus, self.address)

    def connections(self) -> Sequence[Connection]:
        if self.bus == HEADER_BUS:  # Source: https://pinout.xyz/pinout/i2c
            sda, scl = gpio("SDA", 2, is_shared=True), gpio("SCL", 3, is_shared=True)
        else:
            sda, scl = (Connection(line, "I2C", f"{line} of bus {self.bus}", is_shared=True) for line in ("SDA", "SCL"))
        return sda, scl, Connection("address", "I2C", self.place, bool(self.shared_chip), protocol=self.shared_chip)


class ChipDriver(BusDriver):
    """The base class of the drivers of chips on an I2C bus that use Adafruit's libraries."""

    extra: ClassVar[str]
    """The extra of robotcore that installs the chip's library."""
    lock: ClassVar[threading.Lock]
    """Lets only one thread at a time call the chip's library, because all sensors of a library share its buffers."""

    def open_bus(self, undo: ExitStack) -> Any:
        """Open the chip's bus; raises FileNotFoundError if it is switched off. ``undo`` closes the bus."""
        from adafruit_extended_bus import ExtendedI2C

        try:
            bus = ExtendedI2C(self.bus, frequency=None)  # Linux sets the frequency at boot
        except ValueError as error:
            raise FileNotFoundError from error
        undo.callback(bus.deinit)
        return bus

    @contextmanager
    def translate_errors(self, device: str) -> Iterator[None]:
        """Raise the errors of the libraries as DeviceErrors. The context has the lock."""
        try:
            with self.lock:
                yield
        except ImportError as error:
            message = f"its library is not installed ({error}); pip install 'robotcore[{self.extra}]'"
            raise DeviceError(device, message, kind="library-missing") from error
        except FileNotFoundError as error:
            raise build_no_bus_error(device, self.bus) from error
        except Exception as error:
            if isinstance(error, RuntimeError) and not str(error).startswith("Timeout"):  # a wrong identity
                message = f"the chip at I2C {self.place} is no {self.name.upper()} ({error}). Correct address or driver"
                raise DeviceError(device, message, kind="wrong-chip") from error
            raise build_no_answer_error(device, self.bus, self.address, error) from error

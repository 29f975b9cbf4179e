"""The settings of a serial port, and the base class of the drivers on one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, ClassVar, Literal, TypeVar

from pydantic import AfterValidator, Field

from drivers.serial.port import USB
from robotcore.description import StrictModel
from robotcore.hardware import Connection, DeviceBinding, DeviceDriver
from robotcore.text import pluralize


def _validate_place(place: str) -> str:
    if place.startswith("usb:") and not USB.fullmatch(place):
        raise ValueError(
            f"{place!r} is no USB id; write usb:VENDOR:PRODUCT, four hexadecimal digits each, such as usb:1a86:7523, "
            "and add :SERIAL if several ports have that id"
        )
    if not place:
        raise ValueError("the port is empty; name one such as /dev/ttyUSB0")
    return place


PortPlace = Annotated[
    str,
    AfterValidator(_validate_place),
    Field(description="a port such as /dev/ttyUSB0, /dev/serial/by-id/NAME or usb:1a86:7523"),
]
"""A serial port in a robot's file."""


class PortSettings(StrictModel):
    """The settings of a device on a serial port."""

    protocol_name: ClassVar[str]
    """The name of the protocol on the line: only devices with the same protocol share a port."""

    default_baud: ClassVar[int]
    """The baud rate of such boards."""

    is_mute: ClassVar[bool] = False
    """Whether the board never sends anything, so that the driver cannot find out if it is connected."""

    port: PortPlace
    baud: Annotated[int, Field(ge=300, le=4_000_000)] | None = None
    """The baud rate, if it is not ``default_baud``."""

    @property
    def speed(self) -> int:
        """The speed of the line in baud."""
        return self.baud or self.default_baud

    def connections(self, part: str = "") -> tuple[Connection, ...]:
        """Return the connection to the port, and to a part of the board that only one device may use.

        part: the name of that part, such as ``sonar``; empty if there is none.
        """
        protocol = f"{self.protocol_name} at {self.speed} baud"
        instead = "write the same baud for all devices of one board"
        port = Connection("port", "serial", self.port, is_shared=True, instead=instead, protocol=protocol)
        return (port, Connection("side", self.protocol_name, f"{part} at {self.port}")) if part else (port,)


class TimeoutSettings(PortSettings):
    """The settings of a motor on a board with a time-out."""

    board_timeout_s: Annotated[float, Field(ge=0.1, le=5)] = 0.5
    """The board stops its motors if it receives no command for this many seconds."""


Side = Literal["left", "right"]
"""One of a board's two motors, or encoders. Swap the two if the robot turns the wrong way."""


class SideSettings(PortSettings):
    """The settings of a device on one of a board's two sides."""

    side: Side

    def connections(self, part: str = "") -> tuple[Connection, ...]:
        return super().connections(f"{self.side} {part}")


DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=PortSettings)


class SerialDriver(DeviceDriver[DescriptionT, SettingsT]):
    """A driver of a device on a serial port."""

    modules = ("serial",)
    remedy = "pip install 'robotcore[serial]'"
    part: ClassVar[str]
    """The part of the board, such as "motor", that only one device may use."""

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        return settings.connections(self.part)


def list_ports(bindings: Iterable[DeviceBinding]) -> tuple[str, ...]:
    """Return the serial ports of the devices, each once, in the order of the file."""
    wires = (wire for binding in bindings for wire in binding.connections)
    return tuple(dict.fromkeys(wire.where for wire in wires if wire.bus == "serial"))


def summarize_devices(bindings: Sequence[DeviceBinding]) -> str:
    """Return the number of devices and their ports as a text: ``2 devices on /dev/ttyUSB0``."""
    ports = list_ports(bindings)
    return pluralize(len(bindings), "device") + (f" on {', '.join(ports)}" if ports else "")

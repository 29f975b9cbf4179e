"""The base class of the drivers of devices on a serial port."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field

from drivers.serial.port import USB, WINDOWS_NAME
from robotcore.hardware import Connection, DeviceBinding, DeviceDriver


def _validate_place(place: str) -> str:
    if place.startswith("usb:") and not USB.fullmatch(place):
        raise ValueError(
            f"{place!r} is no USB id; write usb:VENDOR:PRODUCT, four hexadecimal digits each, such as usb:1a86:7523, "
            "and add :SERIAL if several ports have that id"
        )
    if not place:
        raise ValueError("the port is empty; write a port such as /dev/ttyUSB0")
    if "/" not in place and not USB.fullmatch(place) and not WINDOWS_NAME.fullmatch(place):
        raise ValueError(
            f"{place!r} is no path of a port; write a path such as /dev/ttyUSB0, COM3 on Windows, or usb:VENDOR:PRODUCT"
        )
    return place


PortPlace = Annotated[
    str,
    AfterValidator(_validate_place),
    Field(description="a port such as /dev/ttyUSB0, /dev/serial/by-id/NAME, COM3 or usb:1a86:7523"),
]
"""The type of a serial port in a robot's file."""


Side = Literal["left", "right"]
"""The side of a motor or an encoder on its board. If the robot turns the wrong way, swap the two sides."""


class SerialDriver(DeviceDriver):
    """The base class of the drivers of devices on a serial port."""

    modules = ("serial",)
    remedy = "pip install 'robotcore[serial]'"

    protocol_name: ClassVar[str]
    """The name of the protocol on the line. Only devices with the same protocol may share a port."""
    default_baud: ClassVar[int]
    """The usual baud rate of boards with this protocol."""
    is_mute: ClassVar[bool] = False
    """Whether the board never sends anything. The driver then cannot detect whether the board is connected."""

    port: PortPlace
    baud: Annotated[int, Field(ge=300, le=4_000_000)] | None = None
    """The baud rate; None means ``default_baud``."""

    part_key: ClassVar[str] = "side"
    """The key of the setting that chooses the part of the board, for messages."""

    @property
    def effective_baud(self) -> int:
        """The baud rate of the line: ``baud``, or else ``default_baud``."""
        return self.baud or self.default_baud

    @property
    def part(self) -> str:
        """The part of the board that only one device may use, such as ``left motor``; ``""`` if there is one device."""
        return ""

    def connections(self) -> Sequence[Connection]:
        protocol = f"{self.protocol_name} at {self.effective_baud} baud"
        remedy = "name drivers of the same board with the same baud" if self.part else ""
        port = Connection("port", "serial", self.port, bool(self.part), remedy, protocol)
        if not self.part:
            return (port,)
        return (port, Connection(self.part_key, self.protocol_name, f"{self.part} at {self.port}"))


def list_ports(bindings: Iterable[DeviceBinding]) -> tuple[str, ...]:
    """Return the serial ports of the devices without duplicates, in the order of the robot's file."""
    wires = (wire for binding in bindings for wire in binding.driver.connections())
    return tuple(dict.fromkeys(wire.where for wire in wires if wire.bus == "serial"))

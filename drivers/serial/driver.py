"""What all drivers on a serial line share: the settings of a port, and the driver's base class."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, ClassVar, Literal, TypeVar

from pydantic import AfterValidator, Field

from drivers.serial.port import USB
from robotcore.description import StrictModel
from robotcore.hardware import Connection, DeviceBinding, DeviceDriver
from robotcore.text import pluralize


def _place(written: str) -> str:
    if written.startswith("usb:") and not USB.fullmatch(written):
        raise ValueError(
            f"{written!r} is no USB id; write usb:VENDOR:PRODUCT, four hexadecimal digits each, such as usb:1a86:7523, "
            "and :SERIAL where there are several"
        )
    if not written:
        raise ValueError("it is empty; name a port such as /dev/ttyUSB0")
    return written


PortPlace = Annotated[
    str,
    AfterValidator(_place),
    Field(description="a port such as /dev/ttyUSB0, /dev/serial/by-id/NAME or usb:1a86:7523"),
]
"""A serial port in a robot's file."""


class PortSettings(StrictModel):
    """The port, and its speed where it is not the one that such boards have."""

    speaks: ClassVar[str]
    """What is spoken on the line: only devices that speak the same share a port."""

    usual_baud: ClassVar[int]

    is_mute: ClassVar[bool] = False
    """Whether nothing ever comes back on the line: then nobody can tell whether a board is there."""

    port: PortPlace
    baud: Annotated[int, Field(ge=300, le=4_000_000)] | None = None

    @property
    def speed(self) -> int:
        """The line's speed in baud."""
        return self.baud or self.usual_baud

    def at(self, what: str = "") -> tuple[Connection, ...]:
        """Return where the port goes, and ``what`` of the board behind it the device has alone."""
        spoken = f"{self.speaks} at {self.speed} baud"
        instead = "write the same baud at all that is on one board"
        port = Connection("port", "serial", self.port, is_shared=True, instead=instead, protocol=spoken)
        return (port, Connection("side", self.speaks, f"{what} at {self.port}")) if what else (port,)


class TimeoutSettings(PortSettings):
    """A motor board's own time-out, in seconds: it stops its motors where it has heard no command for so long."""

    board_timeout_s: Annotated[float, Field(ge=0.1, le=5)] = 0.5


Side = Literal["left", "right"]
"""Which of a board's two motors, or encoders, it is; swap the two where the robot turns the wrong way."""


class SideSettings(PortSettings):
    """One of a board's two sides."""

    side: Side

    def at(self, what: str = "") -> tuple[Connection, ...]:
        return super().at(f"{self.side} {what}")


DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=PortSettings)


class SerialDriver(DeviceDriver[DescriptionT, SettingsT]):
    """A driver of one of a board's devices; ``what`` is the one, such as "motor", that no other device may be."""

    modules = ("serial",)
    remedy = "pip install 'robotcore[serial]'"
    what: ClassVar[str]

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        return settings.at(self.what)


def list_ports(fittings: Iterable[DeviceBinding]) -> tuple[str, ...]:
    """Return the serial ports that devices are on, each once, in the order of the file."""
    wires = (wire for fitting in fittings for wire in fitting.connections)
    return tuple(dict.fromkeys(wire.where for wire in wires if wire.bus == "serial"))


def summarize_devices(fittings: Sequence[DeviceBinding]) -> str:
    """Return how many devices these are, and on which ports, in words."""
    ports = list_ports(fittings)
    return pluralize(len(fittings), "device") + (f" on {', '.join(ports)}" if ports else "")

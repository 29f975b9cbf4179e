"""Where a serial port is: by its path, or by the USB id of what is plugged in."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

_USB = re.compile(r"usb:(?P<vendor>[0-9a-f]{4}):(?P<product>[0-9a-f]{4})(?::(?P<serial>.+))?", re.IGNORECASE)


def _place(written: str) -> str:
    if written.startswith("usb:") and not _USB.fullmatch(written):
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


class PortMissingError(OSError):
    """There is no such port now; says which there are."""


def path_of(place: str) -> str:
    """Return the path, or the name, by which a port is opened now; raises PortMissingError where it is not there."""
    from serial.tools.list_ports import comports

    if not (usb := _USB.fullmatch(place)):
        return place
    vendor, product, serial = int(usb["vendor"], 16), int(usb["product"], 16), usb["serial"]
    ports = list(comports())
    found = [
        port.device
        for port in ports
        if (port.vid, port.pid) == (vendor, product) and serial in (None, port.serial_number)
    ]
    if len(found) == 1:
        return str(found[0])
    if found:
        raise PortMissingError(f"{place} is {len(found)} ports, {', '.join(found)}; add its serial number, or name one")
    there = ", ".join(str(port.device) for port in ports) or "none"
    raise PortMissingError(f"{place} is not plugged in; the ports that are there: {there}")

"""Where a serial port is, in a robot's file: by its path, or by the USB id of what is plugged in."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from drivers.serial.ports.finding import USB


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

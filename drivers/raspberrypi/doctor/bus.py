"""Whether the I2C buses are switched on that a robot has devices on."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from robotcore.hal.finding import Finding
from robotcore.hardware import Fitting

WHAT = "I2C"
HEADER_BUS = 1
"""On GPIO 2 and 3, of every board since 2012."""

HEADER_ON = "sudo raspi-config nonint do_i2c 0, or dtparam=i2c_arm=on in /boot/firmware/config.txt and a restart"
OTHER_ON = "Add dtoverlay=i2c{bus} to /boot/firmware/config.txt and restart; its pins are in overlays/README there"


def bus(root: Path, fittings: Iterable[Fitting]) -> Iterator[Finding]:
    """Look whether there is each bus that a device needs; they are off in a new system."""
    for number, names in sorted(_needed(fittings).items()):
        if (root / f"dev/i2c-{number}").exists():
            yield Finding.ok(WHAT, f"bus {number} is switched on, for {', '.join(names)}")
        else:
            remedy = HEADER_ON if number == HEADER_BUS else OTHER_ON.format(bus=number)
            yield Finding.error(WHAT, f"bus {number} is switched off, but {', '.join(names)} needs it", remedy)


def _needed(fittings: Iterable[Fitting]) -> dict[int, list[str]]:
    """Return the devices on each bus, which an address names: ``0x29 on bus 1``."""
    needed: dict[int, list[str]] = {}
    for fitting in fittings:
        places = " ".join(wire.where for wire in fitting.connections if wire.bus == "I2C")
        for number in sorted({int(number) for number in re.findall(r"bus (\d+)", places)}):
            needed.setdefault(number, []).append(fitting.name)
    return needed

"""Whether the serial ports that a robot has boards on are there, are this user's, and are nobody else's.

Source: https://www.raspberrypi.com/documentation/computers/configuration.html#configuring-uarts
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from drivers.raspberrypi.doctor.board import model
from drivers.raspberrypi.doctor.files import told
from drivers.raspberrypi.doctor.permissions import may_open, remedy_for
from drivers.raspberrypi.uart import NAMES
from robotcore.hal.finding import Finding
from robotcore.hardware import Fitting

WHAT = "serial"
GROUP = "dialout"

SWITCH_ON = "sudo raspi-config nonint do_serial_hw 0, or enable_uart=1 in /boot/firmware/config.txt, and restart"
SWITCH_ON_5 = "sudo raspi-config nonint do_serial_hw 0, or dtparam=uart0=on in /boot/firmware/config.txt, and restart"
NO_CONSOLE = "sudo raspi-config nonint do_serial_cons 1, and restart"
NO_BLUETOOTH = "Name /dev/serial0, which is on the header; or give it this one, dtoverlay=disable-bt, and restart"
DEBUG_PORT = "/dev/ttyAMA10"


def serial(root: Path, fittings: Iterable[Fitting], may_open: Callable[[Path], bool] = may_open) -> Iterator[Finding]:
    """Look at each port that a device is on; what answers there is for the run to find out."""
    for place, names in _needed(fittings).items():
        if place.startswith("usb:"):
            yield _usb(root, place, names)
        else:
            yield _port(root, place, names, may_open)


def _needed(fittings: Iterable[Fitting]) -> dict[str, str]:
    """Return the ports, and which devices are on each, in words."""
    needed: dict[str, list[str]] = {}
    for fitting in fittings:
        for wire in fitting.connections:
            if wire.bus == "serial":
                needed.setdefault(wire.where, []).append(fitting.name)
    return {place: ", ".join(names) for place, names in needed.items()}


def _usb(root: Path, place: str, names: str) -> Finding:
    """Look whether something with that USB id is plugged in."""
    _, vendor, product, *_ = (*place.lower().split(":"), "", "")
    for device in sorted((root / "sys/bus/usb/devices").glob("*/idVendor")):
        if (told(device), told(device.with_name("idProduct"))) == (vendor, product):
            return Finding.ok(WHAT, f"{place} is plugged in, for {names}")
    return Finding.error(WHAT, f"{place} is not plugged in, but {names} needs it", _those_there(root))


def _port(root: Path, place: str, names: str, may_open: Callable[[Path], bool]) -> Finding:
    file = root / place.lstrip("/")
    is_pi_5 = "Raspberry Pi 5" in (model(root) or "")
    if not file.exists():
        remedy = (SWITCH_ON_5 if is_pi_5 else SWITCH_ON) if place in NAMES else _those_there(root)
        return Finding.error(WHAT, f"there is no {place}, but {names} needs it", remedy)
    real = f"/dev/{file.resolve().name}"
    if real in _consoles(root):
        return Finding.error(WHAT, f"{place} is the login console's, but {names} needs it", NO_CONSOLE)
    if place in NAMES and f"/dev/{(root / 'dev/serial1').resolve().name}" == real:
        return Finding.error(WHAT, f"{place} goes to the Bluetooth chip, but {names} needs it", NO_BLUETOOTH)
    if not may_open(file):
        return Finding.error(WHAT, f"this user may not use {place}", remedy_for(root, GROUP))
    if place in NAMES and real == DEBUG_PORT:
        said = f"{place} of a Pi 5 is on the connector between its HDMI sockets, not on the header"
        return Finding.warning(WHAT, said, f"For GPIO 14 and 15 name /dev/ttyAMA0: {SWITCH_ON_5}")
    return Finding.ok(WHAT, f"{place} is there, for {names}")


def _consoles(root: Path) -> set[str]:
    """Return the ports on which the kernel tells, and asks for a login. Source: the kernel's serial-console.rst."""
    try:
        line = told(root / "proc/cmdline")
    except OSError:
        return set()
    return {f"/dev/{name}" for name in re.findall(r"\bconsole=(tty(?:S|AMA)\d+)", line)}


def _those_there(root: Path) -> str:
    ports = sorted(f"/dev/{file.name}" for kind in ("ttyUSB*", "ttyACM*") for file in (root / "dev").glob(kind))
    there = f"; there is {', '.join(ports)}" if ports else "; no other port is there"
    return f"Plug it in, by a cable that carries data{there}"

"""Checks of the buses, serial ports and cameras that a robot needs, and of this user's permissions."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path

from drivers.raspberrypi.cameras.csi import OTHER_NUMPY
from drivers.raspberrypi.doctor.board import model, read_text
from drivers.raspberrypi.header import HEADER_PORTS
from robotcore.hal.finding import Finding
from robotcore.hardware import DeviceBinding

PERMISSIONS = "permissions"
GROUPS = {"gpio": ("gpiochip*", "GPIO pins"), "i2c": ("i2c-1", "the I2C bus"), "video": ("video*", "cameras")}
"""By group: which files of /dev it may open, and what they are. Source: Raspberry Pi OS, 99-com.rules."""


def may_open(file: Path) -> bool:
    """Return whether this process may read and write a file."""
    return os.access(file, os.R_OK | os.W_OK)


def check_permissions(root: Path, may_open: Callable[[Path], bool] = may_open) -> Iterator[Finding]:
    """Look whether this process may open the devices that there are; what is not there is told elsewhere."""
    closed = {group: list(_closed_files(root, pattern, may_open)) for group, (pattern, _) in GROUPS.items()}
    if not any(closed.values()):
        yield _open_finding(root)
    for group, files in closed.items():
        if files:
            said = f"this user may not use {GROUPS[group][1]} ({', '.join(files)})"
            yield Finding.error(PERMISSIONS, said, remedy_for(root, group), kind=f"no-permission-{group}")


def _open_finding(root: Path) -> Finding:
    if there := ", ".join(what for pattern, what in GROUPS.values() if list((root / "dev").glob(pattern))):
        return Finding.ok(PERMISSIONS, f"this user may use {there}", kind="permissions-ok")
    return Finding.warning(
        PERMISSIONS,
        "there are no pins, no I2C bus and no cameras in /dev",
        "Run it outside a container",
        kind="no-devices",
    )


def _closed_files(root: Path, pattern: str, may_open: Callable[[Path], bool]) -> Iterable[str]:
    for file in sorted((root / "dev").glob(pattern)):
        if not may_open(file):
            yield f"/dev/{file.name}"


def remedy_for(root: Path, group: str) -> str:
    """Return what to do: a user who was put into a group has its rights from the next login on."""
    member, gid = _member_and_id(root, group)
    if gid in _groups_of_this_process(root):
        return f"The group {group} does not help: start the board again, or mend its udev rules"
    if member:
        return f"You are in the group {group} since this login: log out and in again, or restart the service"
    return f"sudo usermod -aG {group} $USER, then log out and in again"


def _member_and_id(root: Path, group: str) -> tuple[bool, str | None]:
    """Return whether this user is listed in a group, and the group's number. Source: group(5)."""
    user = os.environ.get("USER", "")
    for line in read_text(root / "etc/group").splitlines():
        name, _, gid, members = (*line.split(":"), "", "", "", "")[:4]
        if name == group:
            return bool(user) and user in members.split(","), gid
    return False, None


def _groups_of_this_process(root: Path) -> list[str]:
    """Return the numbers of its groups. Source: proc_pid_status(5)."""
    lines = read_text(root / "proc/self/status").splitlines()
    return next((line.split()[1:] for line in lines if line.startswith("Groups:")), [])


I2C = "I2C"
HEADER_BUS = 1
"""On GPIO 2 and 3, of every board since 2012."""

HEADER_ON = "sudo raspi-config nonint do_i2c 0, or dtparam=i2c_arm=on in /boot/firmware/config.txt and a restart"
OTHER_ON = "Add dtoverlay=i2c{bus} to /boot/firmware/config.txt and restart; its pins are in overlays/README there"


def check_bus(root: Path, fittings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Look whether there is each bus that a device needs; they are off in a new system."""
    for number, names in sorted(_needed_buses(fittings).items()):
        if (root / f"dev/i2c-{number}").exists():
            yield Finding.ok(I2C, f"bus {number} is switched on, for {', '.join(names)}", kind="i2c-on")
        else:
            remedy = HEADER_ON if number == HEADER_BUS else OTHER_ON.format(bus=number)
            yield Finding.error(
                I2C, f"bus {number} is switched off, but {', '.join(names)} needs it", remedy, kind="i2c-off"
            )


def _needed_buses(fittings: Iterable[DeviceBinding]) -> dict[int, list[str]]:
    """Return the devices on each bus, which an address names: ``0x29 on bus 1``."""
    needed: dict[int, list[str]] = {}
    for fitting in fittings:
        places = " ".join(wire.where for wire in fitting.connections if wire.bus == "I2C")
        for number in sorted({int(number) for number in re.findall(r"bus (\d+)", places)}):
            needed.setdefault(number, []).append(fitting.name)
    return needed


SERIAL = "serial"
SERIAL_GROUP = "dialout"

SWITCH_ON = "sudo raspi-config nonint do_serial_hw 0, or enable_uart=1 in /boot/firmware/config.txt, and restart"
SWITCH_ON_5 = "sudo raspi-config nonint do_serial_hw 0, or dtparam=uart0=on in /boot/firmware/config.txt, and restart"
NO_CONSOLE = "sudo raspi-config nonint do_serial_cons 1, and restart"
NO_BLUETOOTH = "Name /dev/serial0, which is on the header; or give it this one, dtoverlay=disable-bt, and restart"
DEBUG_PORT = "/dev/ttyAMA10"


def check_serial(
    root: Path, fittings: Iterable[DeviceBinding], may_open: Callable[[Path], bool] = may_open
) -> Iterator[Finding]:
    """Look at each port that a device is on; what answers there is for the run to find out."""
    for place, names in _needed_ports(fittings).items():
        if place.startswith("usb:"):
            yield _check_usb(root, place, names)
        else:
            yield _check_port(root, place, names, may_open)


def _needed_ports(fittings: Iterable[DeviceBinding]) -> dict[str, str]:
    """Return the ports, and which devices are on each, in words."""
    needed: dict[str, list[str]] = {}
    for fitting in fittings:
        for wire in fitting.connections:
            if wire.bus == "serial":
                needed.setdefault(wire.where, []).append(fitting.name)
    return {place: ", ".join(names) for place, names in needed.items()}


def _check_usb(root: Path, place: str, names: str) -> Finding:
    """Look whether something with that USB id is plugged in."""
    _, vendor, product, *_ = (*place.lower().split(":"), "", "")
    for device in sorted((root / "sys/bus/usb/devices").glob("*/idVendor")):
        if (read_text(device), read_text(device.with_name("idProduct"))) == (vendor, product):
            return Finding.ok(SERIAL, f"{place} is plugged in, for {names}", kind="usb-port-ok")
    return Finding.error(
        SERIAL, f"{place} is not plugged in, but {names} needs it", _offer_ports(root), kind="usb-port-missing"
    )


def _check_port(root: Path, place: str, names: str, may_open: Callable[[Path], bool]) -> Finding:
    file = root / place.lstrip("/")
    is_pi_5 = "Raspberry Pi 5" in (model(root) or "")
    if not file.exists():
        remedy = (SWITCH_ON_5 if is_pi_5 else SWITCH_ON) if place in HEADER_PORTS else _offer_ports(root)
        return Finding.error(SERIAL, f"there is no {place}, but {names} needs it", remedy, kind="port-missing")
    real = f"/dev/{file.resolve().name}"
    if real in _consoles(root):
        return Finding.error(
            SERIAL, f"{place} is the login console's, but {names} needs it", NO_CONSOLE, kind="port-console"
        )
    if place in HEADER_PORTS and f"/dev/{(root / 'dev/serial1').resolve().name}" == real:
        return Finding.error(
            SERIAL, f"{place} goes to the Bluetooth chip, but {names} needs it", NO_BLUETOOTH, kind="port-bluetooth"
        )
    if not may_open(file):
        return Finding.error(
            SERIAL, f"this user may not use {place}", remedy_for(root, SERIAL_GROUP), kind="port-no-permission"
        )
    if place in HEADER_PORTS and real == DEBUG_PORT:
        said = f"{place} of a Pi 5 is on the connector between its HDMI sockets, not on the header"
        return Finding.warning(
            SERIAL, said, f"For GPIO 14 and 15 name /dev/ttyAMA0: {SWITCH_ON_5}", kind="port-off-header"
        )
    return Finding.ok(SERIAL, f"{place} is there, for {names}", kind="port-ok")


def _consoles(root: Path) -> set[str]:
    """Return the ports on which the kernel tells, and asks for a login. Source: the kernel's serial-console.rst."""
    try:
        line = read_text(root / "proc/cmdline")
    except OSError:
        return set()
    return {f"/dev/{name}" for name in re.findall(r"\bconsole=(tty(?:S|AMA)\d+)", line)}


def _offer_ports(root: Path) -> str:
    ports = sorted(f"/dev/{file.name}" for kind in ("ttyUSB*", "ttyACM*") for file in (root / "dev").glob(kind))
    there = f"; there is {', '.join(ports)}" if ports else "; no other port is there"
    return f"Plug it in, by a cable that carries data{there}"


CAMERA = "camera"
NODES = "sys/class/video4linux/video*/name"
RECEIVERS = ("unicam", "rp1-cfe")
"""What receives pictures from the camera's connector, up to a Pi 4 and on a Pi 5; it is there when a sensor was found.
Sources: the kernel's drivers bcm2835-unicam and rp1-cfe."""

CSI = "CSI"
NO_CAMERA = (
    "Switch the board off and look at the camera's cable: contacts on the right side, pushed in all the way; "
    "camera_auto_detect=1 in /boot/firmware/config.txt; rpicam-hello --list-cameras tells what is found"
)
FROM_APT = "sudo apt install python3-picamera2, and make the venv with --system-site-packages"


def check_cameras(root: Path, fittings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Look whether a robot's cameras are there: a sensor on the connector, the device file of any other one."""
    for fitting in fittings:
        for wire in fitting.connections:
            if wire.bus == CSI:
                yield _check_connector(root, fitting.name, wire.where)
            elif wire.where.startswith("/dev/"):
                yield _check_file(root, fitting.name, wire.where)


def _check_connector(root: Path, name: str, number: str) -> Finding:
    nodes = [read_text(file) for file in sorted(root.glob(NODES))]
    if found := next((node for node in nodes if node.startswith(RECEIVERS)), None):
        if number != "0":
            said = f"there is a sensor ({found}); whether it is camera {number}, for {name}, could not be checked"
            return Finding.warning(
                CAMERA, said, "rpicam-hello --list-cameras tells their numbers", kind="camera-unnumbered"
            )
        return Finding.ok(CAMERA, f"a sensor for {name} is on the connector ({found})", kind="camera-found")
    return Finding.error(
        CAMERA, f"no camera was found on the connector, and {name} needs one", NO_CAMERA, kind="camera-missing"
    )


def _check_file(root: Path, name: str, file: str) -> Finding:
    if (root / file.lstrip("/")).exists():
        return Finding.ok(CAMERA, f"{file} is there, for {name}", kind="camera-file-found")
    return Finding.error(
        CAMERA,
        f"{file} is not there, and {name} needs it",
        "Plug it in; v4l2-ctl --list-devices",
        kind="camera-file-missing",
    )


def check_picamera2(importing: Callable[[str], object] = import_module) -> Iterator[Finding]:
    """Look whether picamera2 can be imported together with this NumPy.

    Source of the fault that is expected: https://github.com/raspberrypi/picamera2/issues/1170.
    """
    try:
        importing("picamera2")
    except ImportError as error:
        yield Finding.error("picamera2", f"cannot be imported: {error}", FROM_APT, kind="picamera2-missing")
    except ValueError as error:  # numpy.dtype size changed, may indicate binary incompatibility
        yield Finding.error(
            "picamera2", f"was built for another NumPy: {error}", OTHER_NUMPY, kind="picamera2-other-numpy"
        )
    else:
        yield Finding.ok("picamera2", "fits this NumPy", kind="picamera2-ok")

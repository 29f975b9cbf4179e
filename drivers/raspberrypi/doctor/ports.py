"""Checks of the permissions, buses, serial ports and cameras that a robot needs."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path

from drivers.raspberrypi.cameras.csi import OTHER_NUMPY
from drivers.raspberrypi.doctor.board import read_model, read_text
from drivers.raspberrypi.header import HEADER_BUS, HEADER_PORTS
from robotcore.hal.check_finding import Finding
from robotcore.hardware import DeviceBinding

PERMISSIONS = "permissions"
GROUPS = {"gpio": ("gpiochip*", "GPIO pins"), "i2c": ("i2c-1", "the I2C bus"), "video": ("video*", "cameras")}
"""The files in /dev that each group may use, and their name in messages. Source: Raspberry Pi OS, 99-com.rules."""


def may_open(file: Path) -> bool:
    """Return whether this process may read and write a file."""
    return os.access(file, os.R_OK | os.W_OK)


def check_permissions(root: Path, may_open: Callable[[Path], bool] = may_open) -> Iterator[Finding]:
    """Check that this process may open the GPIO, I2C and camera files in /dev. Other checks report missing files.

    may_open: returns whether this process may open a file. Tests replace it.
    """
    closed = {group: list(_closed_files(root, pattern, may_open)) for group, (pattern, _) in GROUPS.items()}
    if not any(closed.values()):
        yield _open_finding(root)
    for group, files in closed.items():
        if files:
            message = f"no permission for {GROUPS[group][1]} ({', '.join(files)})"
            yield Finding.error(PERMISSIONS, message, find_remedy(root, group), kind=f"no-permission-{group}")


def _open_finding(root: Path) -> Finding:
    if found := ", ".join(what for pattern, what in GROUPS.values() if list((root / "dev").glob(pattern))):
        return Finding.ok(PERMISSIONS, f"this user may use {found}", kind="permissions-ok")
    return Finding.warning(
        PERMISSIONS,
        "there are no pins, no I2C bus and no cameras in /dev",
        "Run robotcore doctor outside a container",
        kind="no-devices",
    )


def _closed_files(root: Path, pattern: str, may_open: Callable[[Path], bool]) -> Iterable[str]:
    for file in sorted((root / "dev").glob(pattern)):
        if not may_open(file):
            yield f"/dev/{file.name}"


def find_remedy(root: Path, group: str) -> str:
    """Return the remedy if this process has no permission for files of ``group``."""
    member, gid = _member_and_id(root, group)
    if gid in _groups_of_this_process(root):
        return f"This process is in the group {group} already: restart the board, or correct its udev rules"
    if member:
        return f"This user joined the group {group} after the login: log out and in again, or restart the service"
    return f"sudo usermod -aG {group} $USER, then log out and in again"


def _member_and_id(root: Path, group: str) -> tuple[bool, str | None]:
    # The format of /etc/group is in group(5).
    user = os.environ.get("USER", "")
    for line in read_text(root / "etc/group").splitlines():
        name, _, gid, members = (*line.split(":"), "", "", "", "")[:4]
        if name == group:
            return bool(user) and user in members.split(","), gid
    return False, None


def _groups_of_this_process(root: Path) -> list[str]:
    # The format of the file is in proc_pid_status(5).
    lines = read_text(root / "proc/self/status").splitlines()
    return next((line.split()[1:] for line in lines if line.startswith("Groups:")), [])


I2C = "I2C"
HEADER_ON = "sudo raspi-config nonint do_i2c 0, or dtparam=i2c_arm=on in /boot/firmware/config.txt, and restart"
OTHER_ON = (
    "Add dtoverlay=i2c{bus} to /boot/firmware/config.txt and restart; /boot/firmware/overlays/README lists its pins"
)


def check_bus(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check that each I2C bus of these devices is switched on. After the installation of the system, all are off."""
    for number, names in sorted(_needed_buses(bindings).items()):
        if (root / f"dev/i2c-{number}").exists():
            yield Finding.ok(I2C, f"bus {number} is switched on, for {', '.join(names)}", kind="i2c-on")
        else:
            remedy = HEADER_ON if number == HEADER_BUS else OTHER_ON.format(bus=number)
            yield Finding.error(
                I2C, f"bus {number} is switched off, but {', '.join(names)} needs it", remedy, kind="i2c-off"
            )


def _needed_buses(bindings: Iterable[DeviceBinding]) -> dict[int, list[str]]:
    # A wire to a bus has a place such as "0x29 on bus 1".
    needed: dict[int, list[str]] = {}
    for binding in bindings:
        places = " ".join(wire.where for wire in binding.connections if wire.bus == "I2C")
        for number in sorted({int(number) for number in re.findall(r"bus (\d+)", places)}):
            needed.setdefault(number, []).append(binding.name)
    return needed


SERIAL = "serial"
SERIAL_GROUP = "dialout"

SWITCH_ON = "sudo raspi-config nonint do_serial_hw 0, or enable_uart=1 in /boot/firmware/config.txt, and restart"
SWITCH_ON_5 = "sudo raspi-config nonint do_serial_hw 0, or dtparam=uart0=on in /boot/firmware/config.txt, and restart"
NO_CONSOLE = "sudo raspi-config nonint do_serial_cons 1, and restart"
NO_BLUETOOTH = (
    "Write /dev/serial0, which is on the header, in the robot's file. Or connect this port to the header: add "
    "dtoverlay=disable-bt to /boot/firmware/config.txt, and restart"
)
DEBUG_PORT = "/dev/ttyAMA10"


def check_serial(
    root: Path, bindings: Iterable[DeviceBinding], may_open: Callable[[Path], bool] = may_open
) -> Iterator[Finding]:
    """Check each serial port that a device needs, without opening it.

    may_open: returns whether this process may open a file. Tests replace it.
    """
    for place, names in _needed_ports(bindings).items():
        if place.startswith("usb:"):
            yield _check_usb(root, place, names)
        else:
            yield _check_port(root, place, names, may_open)


def _needed_ports(bindings: Iterable[DeviceBinding]) -> dict[str, str]:
    needed: dict[str, list[str]] = {}
    for binding in bindings:
        for wire in binding.connections:
            if wire.bus == "serial":
                needed.setdefault(wire.where, []).append(binding.name)
    return {place: ", ".join(names) for place, names in needed.items()}


def _check_usb(root: Path, place: str, names: str) -> Finding:
    _, vendor, product, *_ = (*place.lower().split(":"), "", "")
    for device in sorted((root / "sys/bus/usb/devices").glob("*/idVendor")):
        if (read_text(device), read_text(device.with_name("idProduct"))) == (vendor, product):
            return Finding.ok(SERIAL, f"{place} is plugged in, for {names}", kind="usb-port-ok")
    return Finding.error(
        SERIAL, f"{place} is not plugged in, but {names} needs it", _offer_ports(root), kind="usb-port-missing"
    )


def _check_port(root: Path, place: str, names: str, may_open: Callable[[Path], bool]) -> Finding:
    file = root / place.lstrip("/")
    is_pi_5 = "Raspberry Pi 5" in (read_model(root) or "")
    if not file.exists():
        remedy = (SWITCH_ON_5 if is_pi_5 else SWITCH_ON) if place in HEADER_PORTS else _offer_ports(root)
        return Finding.error(SERIAL, f"there is no {place}, but {names} needs it", remedy, kind="port-missing")
    real = f"/dev/{file.resolve().name}"
    if real in _consoles(root):
        return Finding.error(
            SERIAL, f"the login console uses {place}, but {names} needs it", NO_CONSOLE, kind="port-console"
        )
    if place in HEADER_PORTS and f"/dev/{(root / 'dev/serial1').resolve().name}" == real:
        return Finding.error(
            SERIAL,
            f"{place} is connected to the Bluetooth chip, but {names} needs it",
            NO_BLUETOOTH,
            kind="port-bluetooth",
        )
    if not may_open(file):
        return Finding.error(
            SERIAL, f"no permission for {place}", find_remedy(root, SERIAL_GROUP), kind="port-no-permission"
        )
    if place in HEADER_PORTS and real == DEBUG_PORT:
        message = f"{place} of a Pi 5 is on the connector between its HDMI sockets, not on the header"
        return Finding.warning(
            SERIAL,
            message,
            f"For GPIO 14 and 15 write /dev/ttyAMA0 in the robot's file: {SWITCH_ON_5}",
            kind="port-off-header",
        )
    return Finding.ok(SERIAL, f"{place} was found, for {names}", kind="port-ok")


def _consoles(root: Path) -> set[str]:
    # Source: the kernel's serial-console.rst
    try:
        line = read_text(root / "proc/cmdline")
    except OSError:
        return set()
    return {f"/dev/{name}" for name in re.findall(r"\bconsole=(tty(?:S|AMA)\d+)", line)}


def _offer_ports(root: Path) -> str:
    ports = sorted(f"/dev/{file.name}" for kind in ("ttyUSB*", "ttyACM*") for file in (root / "dev").glob(kind))
    found = f"Found: {', '.join(ports)}" if ports else "No other port was found"
    return f"Plug the board in by a cable that carries data. {found}"


CAMERA = "camera"
NODES = "sys/class/video4linux/video*/name"
RECEIVERS = ("unicam", "rp1-cfe")
"""The beginnings of the names of the camera connector's video devices: up to a Pi 4, and on a Pi 5. The kernel creates
these devices only if it has found an image sensor. Sources: the kernel's drivers bcm2835-unicam and rp1-cfe."""

CSI = "CSI"
NO_CAMERA = (
    "Switch the board off and check the camera's cable: contacts on the right side, pushed fully in. Set "
    "camera_auto_detect=1 in /boot/firmware/config.txt. List cameras: rpicam-hello --list-cameras"
)
FROM_APT = "sudo apt install python3-picamera2, and make the venv with --system-site-packages"


def check_cameras(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check that each camera is present: on the Pi's connector by its image sensor, on USB by its device file."""
    for binding in bindings:
        for wire in binding.connections:
            if wire.bus == CSI:
                yield _check_connector(root, binding.name, wire.where)
            elif wire.where.startswith("/dev/"):
                yield _check_file(root, binding.name, wire.where)


def _check_connector(root: Path, name: str, number: str) -> Finding:
    nodes = [read_text(file) for file in sorted(root.glob(NODES))]
    if found := next((node for node in nodes if node.startswith(RECEIVERS)), None):
        if number != "0":
            message = (
                f"an image sensor was found ({found}); it is unknown whether it is camera {number}, which {name} needs"
            )
            return Finding.warning(
                CAMERA, message, "List the numbers: rpicam-hello --list-cameras", kind="camera-unnumbered"
            )
        return Finding.ok(CAMERA, f"an image sensor is on the connector, for {name} ({found})", kind="camera-found")
    return Finding.error(
        CAMERA, f"no camera was found on the connector, but {name} needs one", NO_CAMERA, kind="camera-missing"
    )


def _check_file(root: Path, name: str, file: str) -> Finding:
    if (root / file.lstrip("/")).exists():
        return Finding.ok(CAMERA, f"{file} was found, for {name}", kind="camera-file-found")
    return Finding.error(
        CAMERA,
        f"{file} was not found, but {name} needs it",
        "Plug the camera in. List cameras: v4l2-ctl --list-devices",
        kind="camera-file-missing",
    )


def check_picamera2(import_module: Callable[[str], object] = import_module) -> Iterator[Finding]:
    """Check that picamera2 can be imported with this NumPy.

    import_module: imports a module. Tests replace it.
    """
    try:
        import_module("picamera2")
    except ImportError as error:
        yield Finding.error("picamera2", f"cannot be imported: {error}", FROM_APT, kind="picamera2-missing")
    except ValueError as error:  # Source: https://github.com/raspberrypi/picamera2/issues/1170
        yield Finding.error(
            "picamera2", f"was built for another NumPy: {error}", OTHER_NUMPY, kind="picamera2-other-numpy"
        )
    else:
        yield Finding.ok("picamera2", "fits this NumPy", kind="picamera2-ok")

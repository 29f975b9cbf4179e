"""Checks of the GPIOs, permissions, buses, serial ports and cameras that a robot needs."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Iterator
from contextlib import closing
from pathlib import Path

from drivers.raspberrypi.cameras.csi import import_picamera2
from drivers.raspberrypi.chip import find_chip_number, find_holder, load
from drivers.raspberrypi.doctor.system import read_model, read_text
from drivers.raspberrypi.gamepads import EventGamepadDriver
from drivers.raspberrypi.header import HEADER_PORTS
from drivers.raspberrypi.i2c import explain_switch_on
from drivers.raspberrypi.i2c_device import I2CDevice, find_bus
from drivers.raspberrypi.pwm.chip import require_pwm_chip
from drivers.raspberrypi.pwm.settings import ChannelDriver, translate_chip_errors
from robotcore.errors import DeviceError
from robotcore.hal.check_finding import Finding
from robotcore.hardware import DeviceBinding

I2C_LINES = ("SDA", "SCL")

IN_USE = 1
"""The flag of a GPIO line that a program or the kernel holds. Source: lgpio's manual, gpio_get_line_info."""


def find_holders(gpios: Collection[int]) -> dict[int, str]:
    """Return the holders of the given GPIOs, such as ``process 12 (python3)``. Free GPIOs are left out."""
    lgpio = load()
    chip = lgpio.gpiochip_open(find_chip_number())
    try:
        return {gpio: find_holder(gpio) for gpio in gpios if lgpio.gpio_get_line_info(chip, gpio)[2] & IN_USE}
    finally:
        lgpio.gpiochip_close(chip)


def check_pins(bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check that no program holds a GPIO of these devices.

    The lines of an I2C bus are not checked, because the kernel holds them.
    """
    owners = {
        int(wire.where): binding.name
        for binding in bindings
        for wire in binding.driver.connections()
        if wire.bus == "GPIO" and wire.signal not in I2C_LINES
    }
    held = find_holders(sorted(owners)) if owners else {}
    for gpio, holder in held.items():
        message = f"GPIO {gpio} ({owners[gpio]}) is held by {holder}"
        yield Finding.error("pins", message, "End that program, or connect the device elsewhere", kind="gpio-held")
    if owners and not held:
        yield Finding.ok("pins", f"free: GPIO {', '.join(map(str, sorted(owners)))}", kind="gpios-free")


GROUPS = {"gpio": ("gpiochip*", "GPIO pins"), "i2c": ("i2c-1", "the I2C bus"), "video": ("video*", "cameras")}
"""The files in /dev that each group may use, and their name in messages. Source: Raspberry Pi OS, 99-com.rules."""


def check_permissions(root: Path) -> Iterator[Finding]:
    """Check that this process may open the GPIO, I2C and camera files in /dev. Other checks report missing files."""
    allowed, is_closed = [], False
    for group, (pattern, name) in GROUPS.items():
        files = sorted((root / "dev").glob(pattern))
        if closed := [f"/dev/{file.name}" for file in files if not _may_open(file)]:
            is_closed = True
            message = f"no permission for {name} ({', '.join(closed)})"
            yield Finding.error("permissions", message, JOIN.format(group=group), kind=f"no-permission-{group}")
        elif files:
            allowed.append(name)
    if allowed and not is_closed:
        yield Finding.ok("permissions", f"this user may use {', '.join(allowed)}", kind="permissions-ok")
    elif not is_closed:
        message = "there are no pins, no I2C bus and no cameras in /dev"
        yield Finding.warning("permissions", message, "Run robotcore doctor outside a container", kind="no-devices")


def _may_open(file: Path) -> bool:
    return os.access(file, os.R_OK | os.W_OK)


JOIN = "Run sudo usermod -aG {group} $USER, then log out and in again, or restart the service"


def check_bus(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check that each I2C bus of these devices is switched on. After the installation of the system, all are off."""
    needed: dict[int, dict[str, None]] = {}
    for binding, place in _list_places(bindings, "I2C"):
        for number in re.findall(r"bus (\d+)", place):  # such as 0x29 on bus 1
            needed.setdefault(int(number), {})[binding.name] = None
    for bus, devices in sorted(needed.items()):
        names = ", ".join(devices)
        if (root / f"dev/i2c-{bus}").exists():
            yield Finding.ok("I2C", f"bus {bus} is switched on, for {names}", kind="i2c-on")
        else:
            message = f"bus {bus} is switched off, but {_explain_need(devices)}"
            yield Finding.error("I2C", message, explain_switch_on(bus), kind="i2c-off")


def check_pwm_chips(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Read the registers of each PCA9685 of these devices, on a bus that is switched on. No output changes."""
    chips: dict[tuple[int, int], list[str]] = {}
    for binding in bindings:
        if isinstance(driver := binding.driver, ChannelDriver):
            chips.setdefault((driver.bus, driver.address), []).append(binding.name)
    for (bus, address), devices in sorted(chips.items()):
        if (file := find_bus(bus, root)).exists():
            yield _check_pwm_chip(file, bus, address, devices)


def _check_pwm_chip(file: Path, bus: int, address: int, names: list[str]) -> Finding:
    try:
        with translate_chip_errors("I2C", bus, address), closing(I2CDevice(file, address)) as device:
            require_pwm_chip(device)
    except DeviceError as error:
        problem, _, remedy = str(error).removeprefix("I2C: ").partition(". ")
        return Finding.error("I2C", f"{problem}, but {_explain_need(names)}", remedy, kind=error.kind)
    message = f"a PCA9685 answers at 0x{address:02x} on bus {bus}, for {', '.join(names)}"
    return Finding.ok("I2C", message, kind="pwm-chip-ok")


def _explain_need(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last} need it" if first else f"{last} needs it"


def _list_places(bindings: Iterable[DeviceBinding], bus: str) -> list[tuple[DeviceBinding, str]]:
    return [(binding, wire.where) for binding in bindings for wire in binding.driver.connections() if wire.bus == bus]


SWITCH_ON = (
    "Run sudo raspi-config nonint do_serial_hw 0, or add enable_uart=1 to /boot/firmware/config.txt. Then restart"
)
SWITCH_ON_5 = (
    "Run sudo raspi-config nonint do_serial_hw 0, or add dtparam=uart0=on to /boot/firmware/config.txt. Then restart"
)
NO_CONSOLE = "Run sudo raspi-config nonint do_serial_cons 1. Then restart"
NO_BLUETOOTH = (
    "Write /dev/serial0, which is on the header, in the robot's file. Or connect this port to the header: add "
    "dtoverlay=disable-bt to /boot/firmware/config.txt, and restart"
)
DEBUG_PORT = "/dev/ttyAMA10"


def check_serial(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check each serial port that a device needs, without opening it."""
    needed: dict[str, list[str]] = {}
    for binding, place in _list_places(bindings, "serial"):
        needed.setdefault(place, []).append(binding.name)
    for place, names in needed.items():
        check = _check_usb if place.startswith("usb:") else _check_port
        yield check(root, place, names)


def _check_usb(root: Path, place: str, names: list[str]) -> Finding:
    _, vendor, product, *_ = (*place.lower().split(":"), "", "")
    for device in sorted((root / "sys/bus/usb/devices").glob("*/idVendor")):
        if (read_text(device), read_text(device.with_name("idProduct"))) == (vendor, product):
            return Finding.ok("serial", f"{place} is plugged in, for {', '.join(names)}", kind="usb-port-ok")
    message = f"{place} is not plugged in, but {_explain_need(names)}"
    return Finding.error("serial", message, _offer_ports(root), kind="usb-port-missing")


def _check_port(root: Path, place: str, names: list[str]) -> Finding:
    file, is_on_header = root / place.lstrip("/"), place in HEADER_PORTS
    real, bluetooth = (f"/dev/{each.resolve().name}" for each in (file, root / "dev/serial1"))
    switch_on = SWITCH_ON_5 if "Raspberry Pi 5" in read_model(root) else SWITCH_ON
    absent = switch_on if is_on_header else _offer_ports(root)
    needed = f"but {_explain_need(names)}"
    for is_met, kind, problem, remedy in (
        (not file.exists(), "missing", f"there is no {place}", absent),
        (real in _list_consoles(root), "console", f"the login console uses {place}", NO_CONSOLE),
        (is_on_header and real == bluetooth, "bluetooth", f"{place} is connected to the Bluetooth chip", NO_BLUETOOTH),
    ):
        if is_met:
            return Finding.error("serial", f"{problem}, {needed}", remedy, kind=f"port-{kind}")
    if not _may_open(file):
        remedy = JOIN.format(group="dialout")
        return Finding.error("serial", f"no permission for {place}", remedy, kind="port-no-permission")
    if is_on_header and real == DEBUG_PORT:
        message = f"{place} of a Pi 5 is on the connector between its HDMI sockets, not on the header"
        remedy = f"For GPIO 14 and 15 write /dev/ttyAMA0 in the robot's file. {SWITCH_ON_5}"
        return Finding.warning("serial", message, remedy, kind="port-off-header")
    return Finding.ok("serial", f"{place} was found, for {', '.join(names)}", kind="port-ok")


def _list_consoles(root: Path) -> set[str]:
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


NODES = "sys/class/video4linux/video*/name"
RECEIVERS = ("unicam", "rp1-cfe")
"""The beginnings of the names of the camera connector's video devices: up to a Pi 4, and on a Pi 5. The kernel creates
these devices only if it has found an image sensor. Sources: the kernel's drivers bcm2835-unicam and rp1-cfe."""

NO_CAMERA = (
    "Switch the board off and check the camera's cable: contacts on the right side, pushed fully in. Set "
    "camera_auto_detect=1 in /boot/firmware/config.txt. List cameras: rpicam-hello --list-cameras"
)


def check_cameras(root: Path, bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check that each camera is present: on the Pi's connector by its image sensor, on USB by its device file."""
    for binding, number in _list_places(bindings, "CSI"):
        yield _check_connector(root, binding.name, number)
    for binding, file in _list_places(bindings, "USB"):
        if (root / file.lstrip("/")).exists():
            yield Finding.ok("camera", f"{file} was found, for {binding.name}", kind="camera-file-found")
        else:
            message = f"{file} was not found, but {binding.name} needs it"
            remedy = "Plug the camera in. List cameras: v4l2-ctl --list-devices"
            yield Finding.error("camera", message, remedy, kind="camera-file-missing")


def check_gamepads(bindings: Iterable[DeviceBinding]) -> Iterator[Finding]:
    """Check that each gamepad is connected, and that this process may read it."""
    for binding in bindings:
        if isinstance(binding.driver, EventGamepadDriver):
            try:
                pad = binding.driver.find(binding.name)
            except DeviceError as error:
                problem, _, remedy = str(error).partition(". ")
                yield Finding.error("gamepad", problem, remedy, kind=error.kind)
            except ImportError as error:
                message = f"a library is not installed ({error})"
                yield Finding.error(
                    "gamepad", message, f"On the Pi: {EventGamepadDriver.remedy}", kind="library-missing"
                )
            else:
                pad.close()
                yield Finding.ok("gamepad", f"{pad.path} ({pad.name}), for {binding.name}", kind="gamepad-found")


def _check_connector(root: Path, name: str, number: str) -> Finding:
    nodes = [read_text(file) for file in sorted(root.glob(NODES))]
    found = next((node for node in nodes if node.startswith(RECEIVERS)), None)
    if found is None:
        message = f"no camera was found on the connector, but {name} needs one"
        return Finding.error("camera", message, NO_CAMERA, kind="camera-missing")
    if number != "0":
        message = (
            f"an image sensor was found ({found}); it is unknown whether it is camera {number}, which {name} needs"
        )
        remedy = "List the numbers: rpicam-hello --list-cameras"
        return Finding.warning("camera", message, remedy, kind="camera-unnumbered")
    return Finding.ok("camera", f"an image sensor is on the connector, for {name} ({found})", kind="camera-found")


def check_picamera2() -> Iterator[Finding]:
    """Check that picamera2 can be imported with this NumPy."""
    try:
        import_picamera2("picamera2")
    except DeviceError as error:
        problem, _, remedy = str(error).removeprefix("picamera2: ").rpartition(". ")
        yield Finding.error("picamera2", problem, remedy, kind=error.kind)
    else:
        yield Finding.ok("picamera2", "fits this NumPy", kind="picamera2-ok")

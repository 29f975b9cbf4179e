"""Checks of pins, permissions, buses, ports and cameras."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from unittest.mock import Mock

import pytest

from drivers.raspberrypi.doctor import devices
from drivers.raspberrypi.doctor.devices import (
    check_bus,
    check_cameras,
    check_permissions,
    check_picamera2,
    check_pins,
    check_pwm_chips,
    check_serial,
    find_holders,
)
from drivers.raspberrypi.header import gpio
from robotcore.description import load_robot
from robotcore.hal.check_finding import Finding
from robotcore.hardware import Connection, bind_devices
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings
from tests.drivers.raspberrypi.doctor.trees import binding
from tests.drivers.raspberrypi.i2c_dev import use_bus

NOSE = binding("nose", gpio("trigger", 16), gpio("echo", 26))
MOTOR = binding("left_motor", gpio("forward", 17), gpio("backward", 27))
LASER = binding("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
ON_CHIP = binding("right_motor", gpio("SCL", 3, is_shared=True), gpio("phase", 5))
ASIDE = binding("nose", Connection("SDA", "I2C", "SDA of bus 3", is_shared=True))
EYE = binding("eye", Connection("camera", "CSI", "0"))
WEBCAM = binding("eye", Connection("camera", "USB", "/dev/video0"))


@pytest.mark.parametrize(
    "held, kind", [({}, "gpios-free"), ({26: "process 812 (python3)"}, "gpio-held")], ids=["free", "held"]
)
def test_the_pins_of_all_devices_are_checked_but_not_the_lines_of_a_bus(
    held: dict[int, str], kind: str, monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    find = Mock(return_value=held)
    monkeypatch.setattr(devices, "find_holders", find)
    check_findings(check_pins([NOSE, MOTOR, EYE, LASER, ON_CHIP]), kind)
    assert list(check_pins([EYE])) == []
    find.assert_called_once_with([5, 16, 17, 26, 27])


def test_the_kernel_reports_the_lines_in_use(monkeypatch: pytest.MonkeyPatch) -> None:
    lgpio = Mock()
    lgpio.gpio_get_line_info = lambda _, line: [0, line, 0b11 if line == 17 else 0b10, "", ""]
    monkeypatch.setattr(devices, "load", lambda: lgpio)
    monkeypatch.setattr(devices, "find_chip_number", lambda: 0)
    monkeypatch.setattr(devices, "find_holder", lambda line: f"process {line}")
    assert find_holders([16, 17]) == {17: "process 17"}
    lgpio.gpiochip_close.assert_called_once_with(lgpio.gpiochip_open.return_value)


def test_a_bus_is_checked_only_if_a_device_uses_it(
    pi_4: Path, broken_tree: Path, check_findings: CheckFindings
) -> None:
    assert list(check_bus(broken_tree, [NOSE])) == []
    check_findings(check_bus(pi_4, [LASER]), "i2c-on")
    check_findings(check_bus(broken_tree, [LASER]), "i2c-off")
    check_findings(check_bus(pi_4, [ASIDE]), "i2c-off")


def test_registers_of_each_pwm_chip_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    bus = use_bus(tmp_path, monkeypatch)
    jetbot = bind_devices(load_robot("jetbot"), "raspberrypi")
    before = bus.registers
    check_findings(check_pwm_chips(bus.root, jetbot), "pwm-chip-ok")
    assert bus.registers == before
    monkeypatch.setattr("drivers.raspberrypi.i2c_device.I2CDevice.read", lambda _device, register: register)
    check_findings(check_pwm_chips(bus.root, jetbot), "wrong-chip")
    monkeypatch.undo()
    use_bus(tmp_path, monkeypatch).unplug()
    check_findings(check_pwm_chips(bus.root, jetbot), "chip-unanswered")
    assert list(check_pwm_chips(tmp_path / "no bus", jetbot)) == []


def test_a_camera_is_present_by_its_sensor_or_by_its_file(
    pi_4: Path, pi_5: Path, broken_tree: Path, check_findings: CheckFindings
) -> None:
    assert list(check_cameras(broken_tree, [NOSE])) == []
    for tree in (pi_4, pi_5):
        check_findings(check_cameras(tree, [EYE, WEBCAM]), "camera-found", "camera-file-found")
    check_findings(check_cameras(broken_tree, [EYE, WEBCAM]), "camera-missing", "camera-file-missing")
    check_findings(check_cameras(pi_5, [binding("eye", Connection("camera", "CSI", "1"))]), "camera-unnumbered")


def test_picamera2_that_is_missing_is_an_error(monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings) -> None:
    monkeypatch.setitem(sys.modules, "picamera2", None)
    check_findings(check_picamera2(), "picamera2-missing")
    monkeypatch.setitem(sys.modules, "picamera2", ModuleType("picamera2"))
    check_findings(check_picamera2(), "picamera2-ok")


CONSOLE = "coherent_pool=1M console={},115200 console=tty1 root=PARTUUID=1234-02 rootwait\n"


def check_port(root: Path, port: str) -> Finding:
    """Return the finding for a robot whose two motors are on a port."""
    wires = Connection("port", "serial", port, is_shared=True, protocol="something")
    (found,) = check_serial(root, [binding(name, wires) for name in ("left_motor", "right_motor")])
    return found


def link(root: Path, name: str, to: str, console: str = "tty1") -> Path:
    """Add another name of a port to a tree, as udev does, and set the kernel's console."""
    (root / "dev" / to).touch()
    (root / "dev" / name).symlink_to(to)
    (root / "proc/cmdline").write_text(CONSOLE.format(console))
    return root


@pytest.mark.parametrize("console, kind", [("tty1", "port-ok"), ("ttyAMA10", "port-ok"), ("ttyS0", "port-console")])
def test_a_port_on_the_header_is_free_unless_the_login_console_uses_it(
    pi_4: Path, console: str, kind: str, check_findings: CheckFindings
) -> None:
    check_findings([check_port(link(pi_4, "serial0", "ttyS0", console), "/dev/serial0")], kind)


def test_a_missing_port_is_reported_with_the_setting_or_with_the_present_ones(
    pi_4: Path, pi_5: Path, check_findings: CheckFindings
) -> None:
    for tree, port in ((pi_4, "serial0"), (pi_5, "ttyAMA0"), (pi_4, "ttyUSB0")):
        check_findings([check_port(tree, f"/dev/{port}")], "port-missing")
    (pi_4 / "dev/ttyACM0").touch()
    check_findings([check_port(pi_4, "/dev/ttyUSB0")], "port-missing")


def test_a_port_that_is_not_on_the_header_is_reported(pi_4: Path, pi_5: Path, check_findings: CheckFindings) -> None:
    link(link(pi_4, "serial0", "ttyS0"), "serial1", "ttyAMA0")
    assert check_port(pi_4, "/dev/serial0").kind == "port-ok"
    check_findings([check_port(pi_4, "/dev/ttyAMA0")], "port-bluetooth")
    check_findings([check_port(link(pi_5, "serial0", "ttyAMA10"), "/dev/serial0")], "port-off-header")


def test_a_usb_id_is_searched_among_the_plugged_in_devices(pi_4: Path, check_findings: CheckFindings) -> None:
    device = pi_4 / "sys/bus/usb/devices/1-1.2"
    device.mkdir(parents=True)
    (device / "idVendor").write_text("10c4\n")
    (device / "idProduct").write_text("ea60\n")
    found = [check_port(pi_4, name) for name in ("usb:10C4:EA60:0001", "usb:1a86:7523")]
    check_findings(found, "usb-port-ok", "usb-port-missing")


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """The names of the files that this process may not open."""
    names: set[str] = set()
    monkeypatch.setattr("os.access", lambda file, _: file.name not in names)
    return names


def test_a_port_that_this_user_may_not_open_is_an_error_with_the_group(
    pi_4: Path, closed: set[str], check_findings: CheckFindings
) -> None:
    closed.add("ttyUSB0")
    (pi_4 / "dev/ttyUSB0").touch()
    check_findings([check_port(pi_4, "/dev/ttyUSB0")], "port-no-permission")


def test_a_user_who_may_open_everything_is_ok(
    pi_4: Path, tmp_path: Path, closed: set[str], check_findings: CheckFindings
) -> None:
    check_findings(check_permissions(pi_4), "permissions-ok")
    check_findings(check_permissions(tmp_path), "no-devices")


def test_each_kind_of_device_is_reported_with_its_group(
    pi_4: Path, closed: set[str], check_findings: CheckFindings
) -> None:
    closed.update({"gpiochip0", "i2c-1", "video0"})
    check_findings(check_permissions(pi_4), *(f"no-permission-{group}" for group in ("gpio", "i2c", "video")))

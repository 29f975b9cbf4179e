"""Checks of pins, buses, ports, cameras and permissions."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from pathlib import Path
from types import ModuleType

import pytest

from drivers.raspberrypi.doctor.pins import check_pins, find_holders
from drivers.raspberrypi.doctor.ports import (
    check_bus,
    check_cameras,
    check_permissions,
    check_picamera2,
    check_serial,
    may_open,
)
from drivers.raspberrypi.header import gpio
from robotcore.hal.check_finding import Finding, Level
from robotcore.hardware import Connection
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings
from tests.drivers.raspberrypi.doctor.trees import binding

NOSE = binding("nose", gpio("trigger", 16), gpio("echo", 26))
MOTOR = binding("left_motor", gpio("forward", 17), gpio("backward", 27))
LASER = binding("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
ASIDE = binding("nose", Connection("SDA", "I2C", "SDA of bus 3", is_shared=True))
EYE = binding("eye", Connection("camera", "CSI", "0"))
WEBCAM = binding("eye", Connection("camera", "USB", "/dev/video0"))


def test_free_pins_are_ok(check_findings: CheckFindings) -> None:
    checked: list[Collection[int]] = []

    def find_none(gpios: Collection[int]) -> Mapping[int, str]:
        checked.append(gpios)
        return {}

    check_findings(check_pins([NOSE, MOTOR, EYE], find_none), "gpios-free")
    assert checked == [[16, 17, 26, 27]]


def test_each_held_pin_is_reported_with_its_device_and_its_holder(check_findings: CheckFindings) -> None:
    check_findings(check_pins([NOSE, MOTOR], lambda _: {26: "process 812 (python3)"}), "gpio-held")


def test_without_pins_no_line_information_is_read() -> None:
    def fail_if_called(_: Collection[int]) -> Mapping[int, str]:
        pytest.fail("no GPIO is to be checked")

    assert list(check_pins([EYE], fail_if_called)) == []


def test_the_kernel_reports_the_lines_in_use(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[int] = []
    lgpio = ModuleType("lgpio")
    lgpio.gpiochip_open = lambda _: 7  # type: ignore[attr-defined]
    lgpio.gpiochip_close = closed.append  # type: ignore[attr-defined]
    lgpio.gpio_get_line_info = lambda _, line: [0, line, 0b11 if line == 17 else 0b10, "", ""]  # type: ignore[attr-defined]
    monkeypatch.setattr("drivers.raspberrypi.lg.load", lambda: lgpio)
    monkeypatch.setattr("drivers.raspberrypi.lg.find_chip_number", lambda: 0)
    monkeypatch.setattr("drivers.raspberrypi.chip.find_holder", lambda line: f"process {line}")
    assert find_holders([16, 17]) == {17: "process 17"}
    assert closed == [7]


def test_a_bus_is_checked_only_if_a_device_uses_it(
    pi_4: Path, broken_tree: Path, check_findings: CheckFindings
) -> None:
    assert list(check_bus(broken_tree, [NOSE])) == []
    check_findings(check_bus(pi_4, [LASER]), "i2c-on")


def test_a_bus_that_is_switched_off_is_an_error_with_the_command_that_switches_it_on(
    broken_tree: Path, check_findings: CheckFindings
) -> None:
    check_findings(check_bus(broken_tree, [LASER]), "i2c-off")


def test_another_bus_is_switched_on_by_another_line(pi_4: Path, check_findings: CheckFindings) -> None:
    check_findings(check_bus(pi_4, [ASIDE]), "i2c-off")


def test_the_lines_of_a_bus_are_not_checked_as_pins(check_findings: CheckFindings) -> None:
    found = check_pins([LASER, NOSE], lambda gpios: dict.fromkeys(set(gpios) & {2}, "the kernel"))
    check_findings(found, "gpios-free")


def test_a_camera_on_the_connector_is_ok_if_the_kernel_has_found_its_sensor(
    pi_4: Path, pi_5: Path, check_findings: CheckFindings
) -> None:
    check_findings([*check_cameras(pi_4, [EYE]), *check_cameras(pi_5, [EYE])], "camera-found", "camera-found")


def test_a_sensor_on_an_unknown_connector_is_a_warning(pi_5: Path, check_findings: CheckFindings) -> None:
    check_findings(check_cameras(pi_5, [binding("eye", Connection("camera", "CSI", "1"))]), "camera-unnumbered")


def test_the_video_files_of_every_pi_are_no_camera(broken_tree: Path, check_findings: CheckFindings) -> None:
    check_findings(check_cameras(broken_tree, [EYE]), "camera-missing")


def test_a_camera_on_usb_is_ok_if_its_file_exists(pi_4: Path, broken_tree: Path) -> None:
    assert [each.level for pi in (pi_4, broken_tree) for each in check_cameras(pi, [WEBCAM])] == [Level.OK, Level.ERROR]


def test_a_robot_without_camera_needs_none(broken_tree: Path) -> None:
    assert list(check_cameras(broken_tree, [NOSE])) == []


def test_picamera2_for_another_numpy_and_a_missing_one_are_distinguished(
    monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    def raise_binary_incompatibility(_: str) -> object:
        raise ValueError("numpy.dtype size changed, may indicate binary incompatibility")

    monkeypatch.setitem(sys.modules, "picamera2", None)
    assert [each.kind for each in check_picamera2()] == ["picamera2-missing"]
    check_findings(check_picamera2(raise_binary_incompatibility), "picamera2-other-numpy")
    check_findings(check_picamera2(lambda _: None), "picamera2-ok")


CONSOLE = "coherent_pool=1M console={},115200 console=tty1 root=PARTUUID=1234-02 rootwait\n"


def check_port(root: Path, port: str, *, may_open: bool = True) -> Finding:
    """Return the finding for a robot whose two motors are on a port."""
    wires = Connection("port", "serial", port, is_shared=True, protocol="something")
    motors = [binding(name, wires) for name in ("left_motor", "right_motor")]
    (found,) = check_serial(root, motors, lambda _: may_open)
    return found


def link(root: Path, name: str, to: str) -> Path:
    """Add another name of a port to a tree, as udev does."""
    (root / "dev" / to).touch()
    (root / "dev" / name).symlink_to(to)
    return root


def set_kernel_consoles(root: Path, console: str) -> None:
    (root / "proc/cmdline").write_text(CONSOLE.format(console))


def test_a_robot_without_ports_needs_none(pi_4: Path) -> None:
    assert list(check_serial(pi_4, [binding("nose", Connection("trigger", "GPIO", "16"))])) == []


@pytest.mark.parametrize("console", ["tty1", "ttyAMA10"])
def test_a_free_port_is_ok(pi_4: Path, console: str, check_findings: CheckFindings) -> None:
    set_kernel_consoles(link(pi_4, "serial0", "ttyS0"), console)
    check_findings([check_port(pi_4, "/dev/serial0")], "port-ok")


def test_a_switched_off_port_on_the_header_is_an_error_with_a_remedy(
    pi_4: Path, pi_5: Path, check_findings: CheckFindings
) -> None:
    check_findings([check_port(pi_4, "/dev/serial0"), check_port(pi_5, "/dev/ttyAMA0")], "port-missing", "port-missing")


def test_the_login_console_on_the_port_is_an_error(pi_4: Path, check_findings: CheckFindings) -> None:
    set_kernel_consoles(link(pi_4, "serial0", "ttyS0"), "ttyS0")
    check_findings([check_port(pi_4, "/dev/serial0")], "port-console")


def test_the_port_of_the_bluetooth_chip_is_an_error(pi_4: Path, check_findings: CheckFindings) -> None:
    link(link(pi_4, "serial0", "ttyS0"), "serial1", "ttyAMA0")
    assert check_port(pi_4, "/dev/serial0").level is Level.OK
    check_findings([check_port(pi_4, "/dev/ttyAMA0")], "port-bluetooth")


def test_a_pi_5_has_another_port_on_the_header(pi_5: Path, check_findings: CheckFindings) -> None:
    check_findings([check_port(link(pi_5, "serial0", "ttyAMA10"), "/dev/serial0")], "port-off-header")


def test_a_port_that_this_user_may_not_open_is_an_error_with_the_group(
    pi_4: Path, check_findings: CheckFindings
) -> None:
    (pi_4 / "dev/ttyUSB0").touch()
    check_findings([check_port(pi_4, "/dev/ttyUSB0", may_open=False)], "port-no-permission")


def test_a_missing_port_is_reported_with_the_present_ones(pi_4: Path, check_findings: CheckFindings) -> None:
    (pi_4 / "dev/ttyACM0").touch()
    check_findings([check_port(pi_4, "/dev/ttyUSB0")], "port-missing")


def test_a_usb_id_is_searched_among_the_plugged_in_devices(pi_4: Path) -> None:
    device = pi_4 / "sys/bus/usb/devices/1-1.2"
    device.mkdir(parents=True)
    (device / "idVendor").write_text("10c4\n")
    (device / "idProduct").write_text("ea60\n")
    assert check_port(pi_4, "usb:10C4:EA60:0001").level is Level.OK
    assert check_port(pi_4, "usb:1a86:7523").level is Level.ERROR


@pytest.fixture(autouse=True)
def _user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("USER", "pi")


def test_a_user_who_may_open_everything_is_ok(pi_4: Path, check_findings: CheckFindings) -> None:
    check_findings(check_permissions(pi_4, lambda _: True), "permissions-ok")


def test_each_kind_of_device_is_reported_with_its_group(pi_4: Path, check_findings: CheckFindings) -> None:
    (pi_4 / "proc/self/status").write_text("Groups:\t1000 \n")
    (pi_4 / "etc/group").write_text("gpio:x:986:\ni2c:x:994:\nvideo:x:44:\n")
    kinds = [f"no-permission-{group}" for group in ("gpio", "i2c", "video")]
    check_findings(check_permissions(pi_4, lambda _: False), *kinds)


def test_a_new_member_of_a_group_must_log_in_again(broken_tree: Path, check_findings: CheckFindings) -> None:
    check_findings(check_permissions(broken_tree, lambda file: file.name != "gpiochip0"), "no-permission-gpio")


def test_a_group_that_does_not_help_is_not_the_remedy(pi_4: Path, check_findings: CheckFindings) -> None:
    check_findings(check_permissions(pi_4, lambda file: file.name != "i2c-1"), "no-permission-i2c")


def test_without_devices_permissions_are_not_ok(tmp_path: Path, check_findings: CheckFindings) -> None:
    check_findings(check_permissions(tmp_path, lambda _: False), "no-devices")


def test_a_missing_file_may_not_be_opened(tmp_path: Path, pi_4: Path) -> None:
    assert may_open(pi_4 / "dev/gpiochip0")
    assert not may_open(tmp_path / "dev/gpiochip0")

"""Pins, the I2C bus and cameras of a robot's devices."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from pathlib import Path
from types import ModuleType

import pytest

from drivers.raspberrypi.doctor.pins import check_pins, find_users
from drivers.raspberrypi.doctor.ports import (
    check_bus,
    check_cameras,
    check_permissions,
    check_picamera2,
    check_serial,
    may_open,
)
from drivers.raspberrypi.header import gpio
from robotcore.hal.finding import Finding, Level
from robotcore.hardware import Connection
from tests.drivers.raspberrypi.doctor.trees import fitting

NOSE = fitting("nose", gpio("trigger", 16), gpio("echo", 26))
MOTOR = fitting("left_motor", gpio("forward", 17), gpio("backward", 27))
LASER = fitting("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
ASIDE = fitting("nose", Connection("SDA", "I2C", "SDA of bus 3", is_shared=True))
EYE = fitting("eye", Connection("camera", "CSI", "0"))
WEBCAM = fitting("eye", Connection("camera", "USB", "/dev/video0"))


def test_pins_that_nobody_has_are_ok() -> None:
    asked: list[Collection[int]] = []

    def nobody(gpios: Collection[int]) -> Mapping[int, str]:
        asked.append(gpios)
        return {}

    assert list(check_pins([NOSE, MOTOR, EYE], nobody)) == [Finding.ok("pins", "free: GPIO 16, 17, 26, 27")]
    assert asked == [[16, 17, 26, 27]]


def test_each_pin_that_somebody_has_is_told_with_its_device_and_its_holder() -> None:
    (found,) = check_pins([NOSE, MOTOR], lambda _: {26: "process 812 (python3)"})
    assert (found.level, found.said) == (Level.ERROR, "GPIO 26 (nose) is held by process 812 (python3)")


def test_a_robot_without_pins_has_nobody_asked() -> None:
    def never(_: Collection[int]) -> Mapping[int, str]:
        pytest.fail("there is nothing to ask")

    assert list(check_pins([EYE], never)) == []


def test_the_kernel_is_asked_which_lines_are_in_use(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[int] = []
    lgpio = ModuleType("lgpio")
    lgpio.gpiochip_open = lambda _: 7  # type: ignore[attr-defined]
    lgpio.gpiochip_close = closed.append  # type: ignore[attr-defined]
    lgpio.gpio_get_line_info = lambda _, line: [0, line, 0b11 if line == 17 else 0b10, "", ""]  # type: ignore[attr-defined]
    monkeypatch.setattr("drivers.raspberrypi.lg.load", lambda: lgpio)
    monkeypatch.setattr("drivers.raspberrypi.lg.chip_number", lambda: 0)
    monkeypatch.setattr("drivers.raspberrypi.chip.find_holder", lambda line: f"whoever has {line}")
    assert find_users([16, 17]) == {17: "whoever has 17"}
    assert closed == [7]


def test_a_bus_counts_only_where_a_device_is_on_it(pi_4: Path, broken: Path) -> None:
    assert list(check_bus(broken, [NOSE])) == []
    assert list(check_bus(pi_4, [LASER])) == [Finding.ok("I2C", "bus 1 is switched on, for nose")]


def test_a_bus_that_is_switched_off_is_an_error_with_the_command_that_switches_it_on(broken: Path) -> None:
    (found,) = check_bus(broken, [LASER])
    assert (found.level, found.said) == (Level.ERROR, "bus 1 is switched off, but nose needs it")
    assert found.remedy.startswith("sudo raspi-config nonint do_i2c 0")


def test_another_bus_is_switched_on_by_another_line(pi_4: Path) -> None:
    (found,) = check_bus(pi_4, [ASIDE])
    assert (found.level, found.said) == (Level.ERROR, "bus 3 is switched off, but nose needs it")
    assert "dtoverlay=i2c3" in found.remedy


def test_the_lines_of_a_bus_are_the_kernels_own() -> None:
    assert list(check_pins([LASER, NOSE], lambda gpios: dict.fromkeys(set(gpios) & {2}, "the kernel"))) == [
        Finding.ok("pins", "free: GPIO 16, 26")
    ]


def test_a_camera_on_the_connector_is_there_when_the_kernel_has_found_its_sensor(pi_4: Path, pi_5: Path) -> None:
    assert [each.said for pi in (pi_4, pi_5) for each in check_cameras(pi, [EYE])] == [
        "a sensor for eye is on the connector (unicam-image)",
        "a sensor for eye is on the connector (rp1-cfe-csi2_ch0)",
    ]


def test_which_of_two_connectors_a_sensor_is_on_is_not_made_up(pi_5: Path) -> None:
    (found,) = check_cameras(pi_5, [fitting("eye", Connection("camera", "CSI", "1"))])
    assert (found.level, "could not be checked" in found.said) == (Level.WARNING, True)


def test_the_video_files_that_every_pi_has_are_no_camera(broken: Path) -> None:
    (found,) = check_cameras(broken, [EYE])
    assert found.level is Level.ERROR
    assert "cable" in found.remedy


def test_a_camera_on_usb_is_there_when_its_file_is(pi_4: Path, broken: Path) -> None:
    assert [each.level for pi in (pi_4, broken) for each in check_cameras(pi, [WEBCAM])] == [Level.OK, Level.ERROR]


def test_a_robot_without_camera_needs_none(broken: Path) -> None:
    assert list(check_cameras(broken, [NOSE])) == []


def test_picamera2_for_another_numpy_is_told_from_one_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def clashing(_: str) -> object:
        raise ValueError("numpy.dtype size changed, may indicate binary incompatibility")

    monkeypatch.setitem(sys.modules, "picamera2", None)
    (missing,), (clash,), (fine,) = check_picamera2(), check_picamera2(clashing), check_picamera2(lambda _: None)
    assert "apt install python3-picamera2" in missing.remedy
    assert clash.said.startswith("was built for another NumPy: numpy.dtype size changed")
    assert "numpy<2" in clash.remedy
    assert [each.level for each in (missing, clash, fine)] == [Level.ERROR, Level.ERROR, Level.OK]


CONSOLE = "coherent_pool=1M console={},115200 console=tty1 root=PARTUUID=1234-02 rootwait\n"


def on(root: Path, port: str, *, may_open: bool = True) -> Finding:
    """Return what is found of a robot whose two motors are on a port."""
    wires = Connection("port", "serial", port, is_shared=True, spoken="something")
    motors = [fitting(name, wires) for name in ("left_motor", "right_motor")]
    (found,) = check_serial(root, motors, lambda _: may_open)
    return found


def link(root: Path, name: str, to: str) -> Path:
    """Let a tree have a port by another name, as udev makes it."""
    (root / "dev" / to).touch()
    (root / "dev" / name).symlink_to(to)
    return root


def tell_kernel(root: Path, console: str) -> None:
    (root / "proc/cmdline").write_text(CONSOLE.format(console))


def test_a_robot_without_ports_needs_none(pi_4: Path) -> None:
    assert list(check_serial(pi_4, [fitting("nose", Connection("trigger", "GPIO", "16"))])) == []


@pytest.mark.parametrize("console", ["tty1", "ttyAMA10"])
def test_a_port_that_is_there_and_nobody_elses_is_ok(pi_4: Path, console: str) -> None:
    tell_kernel(link(pi_4, "serial0", "ttyS0"), console)
    assert on(pi_4, "/dev/serial0") == Finding.ok("serial", "/dev/serial0 is there, for left_motor, right_motor")


def test_a_port_on_the_header_that_is_switched_off_is_an_error_with_how_to_switch_it_on(pi_4: Path, pi_5: Path) -> None:
    four, five = on(pi_4, "/dev/serial0"), on(pi_5, "/dev/ttyAMA0")
    assert four.said == "there is no /dev/serial0, but left_motor, right_motor needs it"
    assert four.level is five.level is Level.ERROR
    assert "enable_uart=1" in four.remedy
    assert "dtparam=uart0=on" in five.remedy


def test_the_login_console_on_the_port_is_an_error(pi_4: Path) -> None:
    tell_kernel(link(pi_4, "serial0", "ttyS0"), "ttyS0")
    found = on(pi_4, "/dev/serial0")
    assert (found.level, found.said[:40]) == (Level.ERROR, "/dev/serial0 is the login console's, but")
    assert "do_serial_cons 1" in found.remedy


def test_the_port_of_the_bluetooth_chip_is_an_error(pi_4: Path) -> None:
    link(link(pi_4, "serial0", "ttyS0"), "serial1", "ttyAMA0")
    assert on(pi_4, "/dev/serial0").level is Level.OK
    found = on(pi_4, "/dev/ttyAMA0")
    assert (found.level, "Bluetooth" in found.said, "/dev/serial0" in found.remedy) == (Level.ERROR, True, True)


def test_a_pi_5_has_another_port_on_the_header(pi_5: Path) -> None:
    found = on(link(pi_5, "serial0", "ttyAMA10"), "/dev/serial0")
    assert (found.level, "/dev/ttyAMA0" in found.remedy) == (Level.WARNING, True)


def test_a_port_that_this_user_may_not_open_is_an_error_with_the_group(pi_4: Path) -> None:
    (pi_4 / "dev/ttyUSB0").touch()
    found = on(pi_4, "/dev/ttyUSB0", may_open=False)
    assert (found.level, found.said) == (Level.ERROR, "this user may not use /dev/ttyUSB0")
    assert "usermod -aG dialout" in found.remedy


def test_a_port_that_is_not_plugged_in_is_told_with_those_that_are(pi_4: Path) -> None:
    (pi_4 / "dev/ttyACM0").touch()
    assert "there is /dev/ttyACM0" in on(pi_4, "/dev/ttyUSB0").remedy


def test_a_usb_id_is_looked_for_among_what_is_plugged_in(pi_4: Path) -> None:
    device = pi_4 / "sys/bus/usb/devices/1-1.2"
    device.mkdir(parents=True)
    (device / "idVendor").write_text("10c4\n")
    (device / "idProduct").write_text("ea60\n")
    assert on(pi_4, "usb:10C4:EA60:0001").level is Level.OK
    assert on(pi_4, "usb:1a86:7523").level is Level.ERROR


@pytest.fixture(autouse=True)
def _user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("USER", "pi")


def test_a_user_who_may_open_everything_is_ok(pi_4: Path) -> None:
    assert list(check_permissions(pi_4, lambda _: True)) == [
        Finding.ok("permissions", "this user may use GPIO pins, the I2C bus, cameras")
    ]


def test_each_kind_of_device_is_told_with_its_group(pi_4: Path) -> None:
    (pi_4 / "proc/self/status").write_text("Groups:\t1000 \n")
    (pi_4 / "etc/group").write_text("gpio:x:986:\ni2c:x:994:\nvideo:x:44:\n")
    found = list(check_permissions(pi_4, lambda _: False))
    assert [each.level for each in found] == [Level.ERROR] * 3
    assert [each.said.partition("(")[2] for each in found] == ["/dev/gpiochip0)", "/dev/i2c-1)", "/dev/video0)"]
    assert [each.remedy.split()[3] for each in found] == ["gpio", "i2c", "video"]


def test_a_user_who_has_not_logged_in_since_is_told_so(broken: Path) -> None:
    found = list(check_permissions(broken, lambda file: file.name != "gpiochip0"))
    assert [each.level for each in found] == [Level.ERROR]
    assert "log out and in again" in found[0].remedy
    assert "usermod" not in found[0].remedy


def test_a_group_that_does_not_help_is_not_given_as_the_remedy(pi_4: Path) -> None:
    (found,) = check_permissions(pi_4, lambda file: file.name != "i2c-1")
    assert found.remedy.startswith("The group i2c does not help")


def test_where_there_are_no_devices_nothing_is_called_right(tmp_path: Path) -> None:
    (found,) = check_permissions(tmp_path, lambda _: False)
    assert found.level is Level.WARNING
    assert "no pins" in found.said


def test_a_file_that_is_not_there_may_not_be_opened(tmp_path: Path, pi_4: Path) -> None:
    assert may_open(pi_4 / "dev/gpiochip0")
    assert not may_open(tmp_path / "dev/gpiochip0")

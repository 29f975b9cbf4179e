from __future__ import annotations

from pathlib import Path

import pytest

from drivers.raspberrypi.doctor.serial import serial
from robotcore.hal.finding import Finding, Level
from robotcore.hardware import Connection
from tests.drivers.raspberrypi.doctor.fittings import fitting

CONSOLE = "coherent_pool=1M console={},115200 console=tty1 root=PARTUUID=1234-02 rootwait\n"


def on(root: Path, port: str, *, may_open: bool = True) -> Finding:
    """Return what is found of a robot whose two motors are on a port."""
    wires = Connection("port", "serial", port, is_shared=True, spoken="something")
    motors = [fitting(name, wires) for name in ("left_motor", "right_motor")]
    (found,) = serial(root, motors, lambda _: may_open)
    return found


def link(root: Path, name: str, to: str) -> Path:
    """Let a tree have a port by another name, as udev makes it."""
    (root / "dev" / to).touch()
    (root / "dev" / name).symlink_to(to)
    return root


def tell_kernel(root: Path, console: str) -> None:
    (root / "proc/cmdline").write_text(CONSOLE.format(console))


def test_a_robot_without_ports_needs_none(pi_4: Path) -> None:
    assert list(serial(pi_4, [fitting("nose", Connection("trigger", "GPIO", "16"))])) == []


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

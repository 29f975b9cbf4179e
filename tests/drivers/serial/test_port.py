from __future__ import annotations

import errno
import grp
import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from pydantic import TypeAdapter, ValidationError
from serial import SerialException
from serial.tools import list_ports

from drivers.serial import port as port_module
from drivers.serial.driver import PortPlace
from drivers.serial.port import WRITE_TIMEOUT_S, Port, PortMissingError, explain_failure, find_path
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.serial.pty import Pty
from tests.texts import CheckText


@pytest.fixture(autouse=True)
def ports(monkeypatch: pytest.MonkeyPatch) -> None:
    there = [
        ("/dev/ttyS0", None, None, None),
        ("/dev/ttyACM0", 0x2341, 0x0043, "A"),
        ("/dev/ttyACM1", 0x2341, 0x0043, "B"),
        ("/dev/ttyUSB3", 0x1A86, 0x7523, None),
    ]
    names = ("device", "vid", "pid", "serial_number")
    found = [SimpleNamespace(**dict(zip(names, port, strict=True))) for port in there]
    monkeypatch.setattr(list_ports, "comports", lambda: found)


@pytest.mark.parametrize(
    "place, path",
    [
        ("usb:1a86:7523", "/dev/ttyUSB3"),
        ("usb:1A86:7523", "/dev/ttyUSB3"),
        ("usb:2341:0043:B", "/dev/ttyACM1"),
        ("/dev/null", "/dev/null"),
    ],
)
def test_a_port_is_found_by_its_usb_id_or_its_path(place: str, path: str) -> None:
    assert find_path(place) == path


def test_a_port_of_windows_is_found_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    port = SimpleNamespace(device="COM3", vid=None, pid=None, serial_number=None)
    monkeypatch.setattr(list_ports, "comports", lambda: [port])
    assert TypeAdapter(PortPlace).validate_python("com3") == find_path("com3") == "com3"
    with pytest.raises(PortMissingError, match=r"there is no COM4; there is COM3"):
        find_path("COM4")


def test_a_refusal_of_windows_means_another_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pyserial has the error of Windows in its text only."""
    monkeypatch.setattr(port_module, "HAS_POSIX", False)
    error = SerialException("could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5)")
    assert "held by another program" in explain_failure("COM3", "COM3", 9600, error)


def test_a_port_with_a_name_that_is_too_long_is_missing() -> None:
    with pytest.raises(PortMissingError):
        find_path("/" + 300 * "a")


@pytest.mark.parametrize(
    "place", ["usb:2341:0043", "usb:10c4:ea60", "/dev/nowhere"], ids=["two-ports", "unplugged", "no-file"]
)
def test_a_missing_port_is_reported_with_a_list_of_the_ports(place: str, check_text: CheckText) -> None:
    with pytest.raises(PortMissingError) as caught:
        find_path(place)
    check_text(caught.value)


@pytest.mark.parametrize("place", ["", "usb:", "usb:1a86", "usb:1a86:75234", "usb:1a86:7523:"])
def test_an_invalid_place_is_refused(place: str) -> None:
    with pytest.raises(ValidationError):
        TypeAdapter(PortPlace).validate_python(place)


@pytest.mark.parametrize(
    "error",
    [
        ValueError("Failed to set custom baud rate (250000)"),
        SerialException("Could not configure port: (25, 'x')"),
    ],
    ids=["baud", "no-port"],
)
def test_a_failure_to_open_a_port_is_explained_with_a_remedy(error: Exception, check_text: CheckText) -> None:
    check_text(explain_failure("usb:a:b", "/dev/null", 250000, error))


OWN_GROUP = os.getgid() or 5


@pytest.mark.parametrize(
    "group, mode",
    [(OWN_GROUP, 0o660), (OWN_GROUP, 0o600), (0, 0o660)],
    ids=["group-may", "group-may-not", "root-group"],
)
@pytest.mark.posix("Windows has no groups of ports")
def test_the_remedy_names_a_group_only_if_its_members_may_use_the_port(
    monkeypatch: pytest.MonkeyPatch, group: int, mode: int, check_text: CheckText
) -> None:
    monkeypatch.setattr(os, "stat", lambda _: os.stat_result((mode, 0, 0, 1, 0, group, 0, 0, 0, 0)))
    text = explain_failure("usb:a:b", "usb", 9600, SerialException(errno.EACCES, "denied"))
    monkeypatch.undo()
    name = grp.getgrgid(OWN_GROUP).gr_name
    assert (f" {name} $USER" in text) == (mode == 0o660 and group == OWN_GROUP)
    check_text(text, hide=[f" {name} $USER"])


@pytest.mark.posix("it replaces os.write, which only POSIX uses")
def test_a_finished_write_is_no_failure_after_a_long_suspension(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, write = MonotonicClock(), os.write

    def write_part(file: int, data: bytes) -> int:
        written = write(file, data)
        clock.sleep_until(clock.now() + 1.2 * WRITE_TIMEOUT_S)
        return written

    with Pty(tmp_path) as pty:
        port = Port(str(pty.path), 57600)
        port.open()
        monkeypatch.setattr(os, "write", write_part)
        port.write(b"m 20 20\r")
        monkeypatch.undo()
        port.close()
        assert pty.read() == b"m 20 20\r"

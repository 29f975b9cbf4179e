"""Checks of the board, its system, power, disk and clock, and of the library of the pins."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from drivers.raspberrypi.doctor import is_raspberry_pi, system
from drivers.raspberrypi.doctor.system import (
    check_board,
    check_clock,
    check_disk,
    check_library,
    check_persistence,
    check_power,
    check_release,
    find_version,
)
from robotcore.errors import BackendMissingError
from robotcore.hal.check_finding import Level
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings
from tests.drivers.raspberrypi.doctor.trees import create_chip, create_tree
from tests.texts import CheckText


@pytest.mark.parametrize("size, kind", [(8, "board"), (4, "python-32-bit")])
def test_the_board_is_reported_with_the_width_of_its_programs(
    size: int, kind: str, pi_4: Path, monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    monkeypatch.setattr("struct.calcsize", lambda _: size)
    check_findings(check_board(pi_4), kind)


def test_a_laptop_is_no_raspberry_pi(tmp_path: Path, pi_4: Path) -> None:
    assert is_raspberry_pi(pi_4)
    assert not is_raspberry_pi(tmp_path)
    assert not is_raspberry_pi(create_tree(tmp_path, {"proc/device-tree/model": "Orange Pi 5\0"}))


@pytest.mark.parametrize("codename, kind", [("trixie", "system"), ("bullseye", "system-untested")])
def test_the_release_is_reported(
    codename: str, kind: str, monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    about = {"PRETTY_NAME": f"Debian GNU/Linux ({codename})", "VERSION_CODENAME": codename}
    monkeypatch.setattr("platform.freedesktop_os_release", lambda: about)
    check_findings(check_release(), kind)


def write_program(root: Path, name: str, script: str) -> None:
    program = root / "usr/bin" / name
    program.parent.mkdir(parents=True, exist_ok=True)
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)


@pytest.mark.parametrize(
    "word, kinds",
    [
        ("0x0", ["power-ok"]),
        ("0x1", ["voltage-low-now"]),
        ("0x50000", ["voltage-low-earlier"]),
        ("0x8", ["throttled-now"]),
        ("0x20000", ["throttled-earlier"]),
        ("0x50005", ["voltage-low-now"]),
        ("0xD0001", ["voltage-low-now", "throttled-earlier"]),
    ],
)
def test_each_bit_of_the_power_is_reported_once_with_its_remedy(
    word: str, kinds: list[str], tmp_path: Path, check_findings: CheckFindings
) -> None:
    write_program(tmp_path, "vcgencmd", f'[ "$1" = get_throttled ] && echo throttled={word}')
    check_findings(check_power(tmp_path), *kinds)


def test_without_an_answer_of_the_firmwares_program_the_power_is_not_ok(tmp_path: Path, check_text: CheckText) -> None:
    with pytest.raises(FileNotFoundError):
        list(check_power(tmp_path))
    write_program(tmp_path, "vcgencmd", "echo \"error=1 error_msg='Command not registered'\"")
    with pytest.raises(ValueError):  # noqa: PT011  the parser's own
        list(check_power(tmp_path))
    write_program(tmp_path, "vcgencmd", 'echo "VCHI initialization failed" >&2; exit 255')
    with pytest.raises(OSError) as raised:  # noqa: PT011  the check's caller reports it
        list(check_power(tmp_path))
    check_text(raised.value)


@pytest.mark.parametrize("free, kind", [(0.1e9, "disk-full"), (1e9, "disk-low"), (20e9, "disk-ok")])
def test_the_disk_is_checked_by_its_free_space(
    monkeypatch: pytest.MonkeyPatch, free: float, kind: str, check_findings: CheckFindings
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=free))
    check_findings(check_disk(Path("/")), kind)


def test_the_clock_is_ok_by_systemd_timesyncd_or_by_timedatectl(
    pi_4: Path, broken_tree: Path, check_findings: CheckFindings
) -> None:
    check_findings(check_clock(pi_4), "clock-synchronised")
    for answer, kind in (("yes", "clock-synchronised"), ("no", "clock-unsynchronised")):
        arguments = "show --property=NTPSynchronized --value"
        write_program(broken_tree, "timedatectl", f'[ "$*" = "{arguments}" ] && echo {answer}')
        check_findings(check_clock(broken_tree), kind)


def test_outputs_that_outlive_their_program_are_a_warning(
    pi_4: Path, pi_5: Path, broken_tree: Path, tmp_path: Path, check_findings: CheckFindings
) -> None:
    for tree, kind in ((pi_4, "outputs-released"), (broken_tree, "outputs-persist"), (tmp_path, "unchecked")):
        check_findings(check_persistence(tree), kind)
    create_tree(pi_5, {"sys/module/pinctrl_rp1/parameters/persist_gpio_outputs": "Y\n"})
    check_findings(check_persistence(pi_5), "outputs-persist")


@pytest.mark.parametrize("driver", ["pinctrl-rp1", "pinctrl-bcm2835"])
def test_the_driver_of_another_boards_pins_does_not_count(pi_5: Path, driver: str) -> None:
    """strict_gpiod does not change the setting of this driver, so a warning about it would have no remedy."""
    for module in ("pinctrl_rp1", "pinctrl_bcm2835"):
        keeps = module != driver.replace("-", "_")
        create_tree(pi_5, {f"sys/module/{module}/parameters/persist_gpio_outputs": "Y\n" if keeps else "N\n"})
    create_chip(pi_5, 0, driver)
    assert [each.level for each in check_persistence(pi_5)] == [Level.OK]


@pytest.mark.parametrize(
    "lgpio, gpiozero, kinds",
    [
        ("0.2.2.0", "2.0.1.post3", ["pin-factory-ok"]),
        ("0.2.2.0", "2.1", ["pin-factory-ok"]),
        ("0.2.2.0", "2.0.0", ["gpiozero-too-old", "pin-factory-ok"]),
        ("", "2.0.1", ["pin-factory-fails"]),
    ],
)
def test_the_libraries_of_the_pins_are_checked_by_their_versions_and_by_opening_them(
    lgpio: str, gpiozero: str, kinds: list[str], monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    missing = BackendMissingError("lgpio cannot be used: it is not here. sudo apt install python3-lgpio")
    open_pins = Mock(side_effect=None if lgpio else missing)
    monkeypatch.setattr(system, "open_pins", open_pins)
    monkeypatch.setattr(system, "find_version", {"lgpio": lgpio, "gpiozero": gpiozero}.get)
    check_findings(check_library(), *kinds)
    assert open_pins.return_value.close.called == ("pin-factory-ok" in kinds)


def test_versions_are_those_of_the_installed_packages() -> None:
    assert find_version("gpiozero")
    assert find_version("no-such-package") == ""

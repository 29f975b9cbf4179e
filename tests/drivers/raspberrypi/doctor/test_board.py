"""Checks of the board, its power, disk and clock, and of the outputs of killed programs."""

from __future__ import annotations

from collections import namedtuple
from pathlib import Path

import pytest

from drivers.raspberrypi.doctor.board import (
    check_board,
    check_clock,
    check_disk,
    check_power,
    check_release,
    is_raspberry_pi,
    parse_fields,
)
from drivers.raspberrypi.doctor.pins import check_persistence
from robotcore.hal.check_finding import Finding, Level
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings
from tests.drivers.raspberrypi.doctor.trees import create_chip, create_tree
from tests.texts import CheckText


def test_the_board_is_reported_with_the_width_of_its_programs(
    pi_4: Path, pi_5: Path, check_findings: CheckFindings
) -> None:
    check_findings([*check_board(pi_4), *check_board(pi_5)], "board", "board")


def test_a_python_of_32_bits_is_a_warning_with_any_kernel(broken_tree: Path, check_findings: CheckFindings) -> None:
    check_findings(check_board(broken_tree), "python-32-bit")


def test_a_laptop_is_no_raspberry_pi(tmp_path: Path, pi_4: Path) -> None:
    assert is_raspberry_pi(pi_4)
    assert not is_raspberry_pi(tmp_path)
    assert not is_raspberry_pi(create_tree(tmp_path, {"proc/device-tree/model": "Orange Pi 5\0"}))


def test_the_release_is_reported(pi_4: Path, pi_5: Path, broken_tree: Path, check_findings: CheckFindings) -> None:
    check_findings([*check_release(pi_4), *check_release(pi_5)], "system", "system")
    check_findings(check_release(broken_tree), "system-untested")


def test_fields_of_a_release_are_read_with_quotes_or_without() -> None:
    assert parse_fields("# NAME=no\nNAME='Pi OS'\n\nID=debian\n") == {"NAME": "Pi OS", "ID": "debian"}


def read_power(word: str) -> list[Finding]:
    return list(check_power(Path("/"), lambda _: f"throttled={word}\n"))


def test_a_board_without_power_or_heat_problems_is_ok(check_findings: CheckFindings) -> None:
    check_findings(read_power("0x0"), "power-ok")


@pytest.mark.parametrize(
    "word, kind",
    [
        ("0x1", "voltage-low-now"),
        ("0x50000", "voltage-low-earlier"),
        ("0x8", "throttled-now"),
        ("0x20000", "throttled-earlier"),
    ],
)
def test_each_bit_is_reported_with_its_remedy(word: str, kind: str, check_findings: CheckFindings) -> None:
    check_findings(read_power(word), kind)


def test_a_present_problem_is_not_repeated_as_an_earlier_one(check_findings: CheckFindings) -> None:
    check_findings(read_power("0x50005"), "voltage-low-now")
    check_findings(read_power("0xD0001"), "voltage-low-now", "throttled-earlier")


def test_an_invalid_answer_is_not_ok() -> None:
    with pytest.raises(ValueError):  # noqa: PT011  the parser's own
        list(check_power(Path("/"), lambda _: "error=1 error_msg='Command not registered'"))


def test_the_firmware_s_program_gives_the_answer(tmp_path: Path, check_text: CheckText) -> None:
    program = tmp_path / "usr/bin/vcgencmd"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n[ "$1" = get_throttled ] && echo throttled=0x0\n')
    program.chmod(0o755)
    assert [each.level for each in check_power(tmp_path)] == [Level.OK]
    program.write_text('#!/bin/sh\necho "VCHI initialization failed" >&2; exit 255\n')
    with pytest.raises(OSError) as raised:  # noqa: PT011  the check's caller reports it
        list(check_power(tmp_path))
    check_text(raised.value)


def test_a_system_without_the_program_is_not_ok(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        list(check_power(tmp_path))


Usage = namedtuple("Usage", "total used free")  # noqa: PYI024  as shutil defines it


def test_a_kernel_that_releases_outputs_is_ok(pi_4: Path, pi_5: Path) -> None:
    assert [each.level for pi in (pi_4, pi_5) for each in check_persistence(pi)] == [Level.OK, Level.OK]


def test_a_kernel_that_keeps_outputs_is_a_warning_with_the_line_that_switches_it_off(
    broken_tree: Path, check_findings: CheckFindings
) -> None:
    check_findings(check_persistence(broken_tree), "outputs-persist")


def test_the_chip_that_has_the_pins_of_a_pi_5_counts_too(pi_5: Path, check_findings: CheckFindings) -> None:
    create_tree(pi_5, {"sys/module/pinctrl_rp1/parameters/persist_gpio_outputs": "Y\n"})
    check_findings(check_persistence(pi_5), "outputs-persist")


@pytest.mark.parametrize("driver", ["pinctrl-rp1", "pinctrl-bcm2835"])
def test_the_driver_of_another_board_s_pins_does_not_count(pi_5: Path, driver: str) -> None:
    """strict_gpiod does not change the setting of this driver, so a warning about it would have no remedy."""
    for module in ("pinctrl_rp1", "pinctrl_bcm2835"):
        keeps = module != driver.replace("-", "_")
        create_tree(pi_5, {f"sys/module/{module}/parameters/persist_gpio_outputs": "Y\n" if keeps else "N\n"})
    create_chip(pi_5, 0, driver)
    assert [each.level for each in check_persistence(pi_5)] == [Level.OK]


def test_a_kernel_without_the_parameter_is_not_ok(tmp_path: Path, check_findings: CheckFindings) -> None:
    check_findings(check_persistence(tmp_path), "unchecked")


@pytest.mark.parametrize("free, kind", [(0.1e9, "disk-full"), (1e9, "disk-low"), (20e9, "disk-ok")])
def test_the_disk_is_checked_by_its_free_space(
    monkeypatch: pytest.MonkeyPatch, free: float, kind: str, check_findings: CheckFindings
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda _: Usage(32e9, 32e9 - free, free))
    check_findings(check_disk(Path("/")), kind)


def fail_if_called(_: Path) -> str:
    pytest.fail("timedatectl was called, although a time server has set the clock")


def test_a_clock_that_a_time_server_has_set_is_ok(pi_4: Path) -> None:
    assert [each.level for each in check_clock(pi_4, fail_if_called)] == [Level.OK]


@pytest.mark.parametrize("answer, level", [("yes\n", Level.OK), ("no\n", Level.WARNING)])
def test_without_systemd_timesyncd_timedatectl_gives_the_answer(broken_tree: Path, answer: str, level: Level) -> None:
    assert [each.level for each in check_clock(broken_tree, lambda _: answer)] == [level]


def test_timedatectl_runs_from_the_board_s_files(tmp_path: Path) -> None:
    program = tmp_path / "usr/bin/timedatectl"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n[ "$*" = "show --property=NTPSynchronized --value" ] && echo yes\n')
    program.chmod(0o755)
    assert [each.level for each in check_clock(tmp_path)] == [Level.OK]

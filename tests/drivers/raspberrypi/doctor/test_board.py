"""The disk, the clock, and outputs that outlive their program."""

from __future__ import annotations

from collections import namedtuple
from pathlib import Path

import pytest

from drivers.raspberrypi.doctor.board import (
    COOLER,
    STRONGER,
    check_board,
    check_clock,
    check_disk,
    check_power,
    check_release,
    is_raspberry_pi,
    parse_fields,
)
from drivers.raspberrypi.doctor.pins import check_persistence
from robotcore.hal.finding import Finding, Level
from tests.drivers.raspberrypi.doctor.trees import grow_chip, grown


def test_the_board_is_told_by_its_name_and_the_width_of_its_programs(pi_4: Path, pi_5: Path) -> None:
    assert list(check_board(pi_4)) == [Finding.ok("board", "Raspberry Pi 4 Model B Rev 1.4, 64-bit Python")]
    assert list(check_board(pi_5)) == [Finding.ok("board", "Raspberry Pi 5 Model B Rev 1.0, 64-bit Python")]


def test_a_python_of_32_bits_is_a_warning_whatever_the_kernel_is(broken: Path) -> None:
    (found,) = check_board(broken)
    assert found.level is Level.WARNING
    assert found.said.endswith("32-bit Python")
    assert "64-bit Raspberry Pi OS" in found.remedy


def test_a_laptop_is_no_raspberry_pi(tmp_path: Path, pi_4: Path) -> None:
    assert is_raspberry_pi(pi_4)
    assert not is_raspberry_pi(tmp_path)
    assert not is_raspberry_pi(grown(tmp_path, {"proc/device-tree/model": "Orange Pi 5\0"}))


def test_releases_are_told_by_their_names(pi_4: Path, pi_5: Path, broken: Path) -> None:
    assert [each.said for each in check_release(pi_4)] == ["Debian GNU/Linux 12 (bookworm)"]
    assert [each.level for each in check_release(pi_5)] == [Level.OK]
    (found,) = check_release(broken)
    assert found.level is Level.WARNING
    assert found.said.startswith("Raspbian GNU/Linux 11 (bullseye)")
    assert "Bookworm or Trixie" in found.remedy


def test_fields_of_a_release_are_read_with_quotes_or_without() -> None:
    assert parse_fields("# NAME=no\nNAME='Pi OS'\n\nID=debian\n") == {"NAME": "Pi OS", "ID": "debian"}


def found(word: str) -> list[tuple[Level, str, str]]:
    findings = check_power(Path("/"), lambda _: f"throttled={word}\n")
    return [(each.level, each.said, each.remedy) for each in findings]


def test_a_board_that_was_always_strong_and_cool_is_ok() -> None:
    assert [level for level, _, _ in found("0x0")] == [Level.OK]


@pytest.mark.parametrize(
    "word, level, said, remedy",
    [
        ("0x1", Level.ERROR, "the voltage is low now", STRONGER),
        ("0x50000", Level.WARNING, "at some time since the start: the voltage is low, the chip is throttled", STRONGER),
        ("0x8", Level.WARNING, "the chip is at its soft temperature limit now", COOLER),
        ("0x20000", Level.WARNING, "at some time since the start: the clock is capped", COOLER),
    ],
)
def test_each_bit_is_told_with_its_remedy(word: str, level: Level, said: str, remedy: str) -> None:
    assert found(word) == [(level, said, remedy)]


def test_what_is_now_is_not_told_once_more_as_what_was() -> None:
    assert [said for _, said, _ in found("0x50005")] == ["the voltage is low, the chip is throttled now"]
    assert [level for level, _, _ in found("0xD0001")] == [Level.ERROR, Level.WARNING]


def test_an_answer_that_is_none_is_no_ok() -> None:
    with pytest.raises(ValueError, match="invalid literal"):
        list(check_power(Path("/"), lambda _: "error=1 error_msg='Command not registered'"))


def test_the_firmwares_own_program_is_asked(tmp_path: Path) -> None:
    program = tmp_path / "usr/bin/vcgencmd"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n[ "$1" = get_throttled ] && echo throttled=0x0\n')
    program.chmod(0o755)
    assert [each.level for each in check_power(tmp_path)] == [Level.OK]
    program.write_text('#!/bin/sh\necho "VCHI initialization failed" >&2; exit 255\n')
    with pytest.raises(OSError, match="vcgencmd says: VCHI initialization failed"):
        list(check_power(tmp_path))


def test_a_system_without_the_program_is_not_ok_either(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        list(check_power(tmp_path))


Usage = namedtuple("Usage", "total used free")  # noqa: PYI024  as shutil has it


def test_a_pi_whose_kernel_lets_go_of_outputs_is_ok(pi_4: Path, pi_5: Path) -> None:
    assert [each.level for pi in (pi_4, pi_5) for each in check_persistence(pi)] == [Level.OK, Level.OK]


def test_a_kernel_that_keeps_outputs_is_a_warning_with_the_line_that_switches_it_off(broken: Path) -> None:
    (found,) = check_persistence(broken)
    assert found.level is Level.WARNING
    assert "pinctrl_bcm2835.persist_gpio_outputs=Y" in found.said
    assert "dtparam=strict_gpiod" in found.remedy


def test_the_chip_that_has_the_pins_of_a_pi_5_counts_too(pi_5: Path) -> None:
    grown(pi_5, {"sys/module/pinctrl_rp1/parameters/persist_gpio_outputs": "Y\n"})
    (found,) = check_persistence(pi_5)
    assert "(pinctrl_rp1.persist_gpio_outputs=Y)" in found.said


@pytest.mark.parametrize("driver", ["pinctrl-rp1", "pinctrl-bcm2835"])
def test_the_driver_of_another_board_s_pins_does_not_count(pi_5: Path, driver: str) -> None:
    """Its setting is never changed by strict_gpiod, which would be asked for again and again."""
    for module in ("pinctrl_rp1", "pinctrl_bcm2835"):
        keeps = module != driver.replace("-", "_")
        grown(pi_5, {f"sys/module/{module}/parameters/persist_gpio_outputs": "Y\n" if keeps else "N\n"})
    grow_chip(pi_5, 0, driver)
    assert [each.level for each in check_persistence(pi_5)] == [Level.OK]


def test_a_kernel_that_does_not_tell_is_never_taken_for_ok(tmp_path: Path) -> None:
    (found,) = check_persistence(tmp_path)
    assert found.level is Level.WARNING
    assert found.said.startswith("could not be checked: ")
    assert found.remedy


@pytest.mark.parametrize("free, level", [(0.1e9, Level.ERROR), (1e9, Level.WARNING), (20e9, Level.OK)])
def test_a_disk_is_judged_by_what_is_free(monkeypatch: pytest.MonkeyPatch, free: float, level: Level) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda _: Usage(32e9, 32e9 - free, free))
    (found,) = check_disk(Path("/"))
    assert (found.level, found.said) == (level, f"{free / 1e9:.1f} GB are free")


def never(_: Path) -> str:
    pytest.fail("nobody else need be asked")


def test_a_clock_that_a_time_server_has_set_is_ok(pi_4: Path) -> None:
    assert [each.level for each in check_clock(pi_4, never)] == [Level.OK]


@pytest.mark.parametrize("answer, level", [("yes\n", Level.OK), ("no\n", Level.WARNING)])
def test_where_systemds_own_program_keeps_no_time_timedatectl_is_asked(broken: Path, answer: str, level: Level) -> None:
    assert [each.level for each in check_clock(broken, lambda _: answer)] == [level]


def test_timedatectl_is_asked_as_it_is_on_the_board(tmp_path: Path) -> None:
    program = tmp_path / "usr/bin/timedatectl"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n[ "$*" = "show --property=NTPSynchronized --value" ] && echo yes\n')
    program.chmod(0o755)
    assert [each.level for each in check_clock(tmp_path)] == [Level.OK]

from __future__ import annotations

from pathlib import Path

from drivers.raspberrypi.doctor.board import board, is_raspberry_pi
from drivers.raspberrypi.doctor.release import fields, release
from robotcore.hal.finding import Finding, Level
from tests.drivers.raspberrypi.doctor.trees import grown


def test_the_board_is_told_by_its_name_and_the_width_of_its_programs(pi_4: Path, pi_5: Path) -> None:
    assert list(board(pi_4)) == [Finding.ok("board", "Raspberry Pi 4 Model B Rev 1.4, 64-bit Python")]
    assert list(board(pi_5)) == [Finding.ok("board", "Raspberry Pi 5 Model B Rev 1.0, 64-bit Python")]


def test_a_python_of_32_bits_is_a_warning_whatever_the_kernel_is(broken: Path) -> None:
    (found,) = board(broken)
    assert found.level is Level.WARNING
    assert found.said.endswith("32-bit Python")
    assert "64-bit Raspberry Pi OS" in found.remedy


def test_a_laptop_is_no_raspberry_pi(tmp_path: Path, pi_4: Path) -> None:
    assert is_raspberry_pi(pi_4)
    assert not is_raspberry_pi(tmp_path)
    assert not is_raspberry_pi(grown(tmp_path, {"proc/device-tree/model": "Orange Pi 5\0"}))


def test_releases_are_told_by_their_names(pi_4: Path, pi_5: Path, broken: Path) -> None:
    assert [each.said for each in release(pi_4)] == ["Debian GNU/Linux 12 (bookworm)"]
    assert [each.level for each in release(pi_5)] == [Level.OK]
    (found,) = release(broken)
    assert found.level is Level.WARNING
    assert found.said.startswith("Raspbian GNU/Linux 11 (bullseye)")
    assert "Bookworm or Trixie" in found.remedy


def test_fields_of_a_release_are_read_with_quotes_or_without() -> None:
    assert fields("# NAME=no\nNAME='Pi OS'\n\nID=debian\n") == {"NAME": "Pi OS", "ID": "debian"}

"""The disk, the clock, and outputs that outlive their program."""

from __future__ import annotations

from collections import namedtuple
from pathlib import Path

import pytest

from drivers.raspberrypi.doctor.clock import clock
from drivers.raspberrypi.doctor.disk import disk
from drivers.raspberrypi.doctor.persistence import persistence
from robotcore.hal.finding import Level
from tests.drivers.raspberrypi.doctor.trees import grow_chip, grown

Usage = namedtuple("Usage", "total used free")  # noqa: PYI024  as shutil has it


def test_a_pi_whose_kernel_lets_go_of_outputs_is_ok(pi_4: Path, pi_5: Path) -> None:
    assert [each.level for pi in (pi_4, pi_5) for each in persistence(pi)] == [Level.OK, Level.OK]


def test_a_kernel_that_keeps_outputs_is_a_warning_with_the_line_that_switches_it_off(broken: Path) -> None:
    (found,) = persistence(broken)
    assert found.level is Level.WARNING
    assert "pinctrl_bcm2835.persist_gpio_outputs=Y" in found.said
    assert "dtparam=strict_gpiod" in found.remedy


def test_the_chip_that_has_the_pins_of_a_pi_5_counts_too(pi_5: Path) -> None:
    grown(pi_5, {"sys/module/pinctrl_rp1/parameters/persist_gpio_outputs": "Y\n"})
    (found,) = persistence(pi_5)
    assert "(pinctrl_rp1.persist_gpio_outputs=Y)" in found.said


@pytest.mark.parametrize("driver", ["pinctrl-rp1", "pinctrl-bcm2835"])
def test_the_driver_of_another_board_s_pins_does_not_count(pi_5: Path, driver: str) -> None:
    """Its setting is never changed by strict_gpiod, which would be asked for again and again."""
    for module in ("pinctrl_rp1", "pinctrl_bcm2835"):
        keeps = module != driver.replace("-", "_")
        grown(pi_5, {f"sys/module/{module}/parameters/persist_gpio_outputs": "Y\n" if keeps else "N\n"})
    grow_chip(pi_5, 0, driver)
    assert [each.level for each in persistence(pi_5)] == [Level.OK]


def test_a_kernel_that_does_not_tell_is_never_taken_for_ok(tmp_path: Path) -> None:
    (found,) = persistence(tmp_path)
    assert found.level is Level.WARNING
    assert found.said.startswith("could not be checked: ")
    assert found.remedy


@pytest.mark.parametrize("free, level", [(0.1e9, Level.ERROR), (1e9, Level.WARNING), (20e9, Level.OK)])
def test_a_disk_is_judged_by_what_is_free(monkeypatch: pytest.MonkeyPatch, free: float, level: Level) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda _: Usage(32e9, 32e9 - free, free))
    (found,) = disk(Path("/"))
    assert (found.level, found.said) == (level, f"{free / 1e9:.1f} GB are free")


def never(_: Path) -> str:
    pytest.fail("nobody else need be asked")


def test_a_clock_that_a_time_server_has_set_is_ok(pi_4: Path) -> None:
    assert [each.level for each in clock(pi_4, never)] == [Level.OK]


@pytest.mark.parametrize("answer, level", [("yes\n", Level.OK), ("no\n", Level.WARNING)])
def test_where_systemds_own_program_keeps_no_time_timedatectl_is_asked(broken: Path, answer: str, level: Level) -> None:
    assert [each.level for each in clock(broken, lambda _: answer)] == [level]


def test_timedatectl_is_asked_as_it_is_on_the_board(tmp_path: Path) -> None:
    program = tmp_path / "usr/bin/timedatectl"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n[ "$*" = "show --property=NTPSynchronized --value" ] && echo yes\n')
    program.chmod(0o755)
    assert [each.level for each in clock(tmp_path)] == [Level.OK]

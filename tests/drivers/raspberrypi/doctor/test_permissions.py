from __future__ import annotations

from pathlib import Path

import pytest

from drivers.raspberrypi.doctor.permissions import may_open, permissions
from robotcore.hal.finding import Finding, Level


@pytest.fixture(autouse=True)
def _user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("USER", "pi")


def test_a_user_who_may_open_everything_is_ok(pi_4: Path) -> None:
    assert list(permissions(pi_4, lambda _: True)) == [
        Finding.ok("permissions", "this user may use GPIO pins, the I2C bus, cameras")
    ]


def test_each_kind_of_device_is_told_with_its_group(pi_4: Path) -> None:
    (pi_4 / "proc/self/status").write_text("Groups:\t1000 \n")
    (pi_4 / "etc/group").write_text("gpio:x:986:\ni2c:x:994:\nvideo:x:44:\n")
    found = list(permissions(pi_4, lambda _: False))
    assert [each.level for each in found] == [Level.ERROR] * 3
    assert [each.said.partition("(")[2] for each in found] == ["/dev/gpiochip0)", "/dev/i2c-1)", "/dev/video0)"]
    assert [each.remedy.split()[3] for each in found] == ["gpio", "i2c", "video"]


def test_a_user_who_has_not_logged_in_since_is_told_so(broken: Path) -> None:
    found = list(permissions(broken, lambda file: file.name != "gpiochip0"))
    assert [each.level for each in found] == [Level.ERROR]
    assert "log out and in again" in found[0].remedy
    assert "usermod" not in found[0].remedy


def test_a_group_that_does_not_help_is_not_given_as_the_remedy(pi_4: Path) -> None:
    (found,) = permissions(pi_4, lambda file: file.name != "i2c-1")
    assert found.remedy.startswith("The group i2c does not help")


def test_where_there_are_no_devices_nothing_is_called_right(tmp_path: Path) -> None:
    (found,) = permissions(tmp_path, lambda _: False)
    assert found.level is Level.WARNING
    assert "no pins" in found.said


def test_a_file_that_is_not_there_may_not_be_opened(tmp_path: Path, pi_4: Path) -> None:
    assert may_open(pi_4 / "dev/gpiochip0")
    assert not may_open(tmp_path / "dev/gpiochip0")

"""What is told of a guest's checks, without a guest."""

from __future__ import annotations

import pytest

from tests.system import needs
from tests.system.gpio.report import Report

BEGUN, PASSED = '{"begun": "motors: a stop"}', '{"passed": "motors: a stop"}'
FAILED = '{"failed": "motors: a stop", "why": "assert [17] == []"}'
ENDED = '{"ended": "0"}'


def heard(*lines: str) -> Report:
    report = Report()
    report.hear(lines)
    return report


def test_checks_that_all_passed_are_passed_when_the_guest_has_ended(capsys: pytest.CaptureFixture[str]) -> None:
    assert heard("noise of the firmware", BEGUN, PASSED, ENDED).is_passed
    assert capsys.readouterr().out == "ok      motors: a stop\n"


def test_a_failed_check_is_reported_with_what_was_got_and_expected(capsys: pytest.CaptureFixture[str]) -> None:
    assert not heard(BEGUN, FAILED, ENDED).is_passed
    assert capsys.readouterr().out == "not ok  motors: a stop\n          assert [17] == []\n"


def test_a_check_that_hangs_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert not heard(BEGUN).is_passed
    assert capsys.readouterr().out.startswith("not ok  motors: a stop\n")


def test_a_guest_that_does_not_start_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    assert not heard().is_passed
    assert "the start of the guest" in capsys.readouterr().out


def test_what_cannot_run_here_says_why_and_is_no_failure(capsys: pytest.CaptureFixture[str]) -> None:
    def lacking() -> bool:
        raise needs.NotRunError("needs root")

    assert needs.run_or_skip("gpio", lacking) == needs.NOT_RUN
    assert capsys.readouterr().out == "gpio: not run: needs root\n"


def test_who_is_not_root_is_reported_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platform.freedesktop_os_release", lambda: {"ID": "debian", "VERSION_ID": "12"})
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    with pytest.raises(needs.NotRunError, match=r"^needs root"):
        needs.debian()


def test_another_system_is_reported_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    other = {"ID": "ubuntu", "VERSION_ID": "24.04", "PRETTY_NAME": "Ubuntu 24.04"}
    monkeypatch.setattr("platform.freedesktop_os_release", lambda: other)
    with pytest.raises(needs.NotRunError, match=r"needs Debian 12 on x86_64 .*; this is Ubuntu 24.04"):
        needs.debian()


def test_a_package_that_cannot_be_had_is_reported_with_what_apt_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.system.needs._is_installed", lambda name: name != "qemu-system-x86")
    monkeypatch.setattr("tests.system.needs._apt", lambda *_: "E: Unable to fetch some archives")
    with pytest.raises(needs.NotRunError, match=r"^needs qemu-system-x86, and apt-get said: E: Unable to fetch"):
        needs.packages("qemu-system-x86", "kmod")

"""The report of a guest's checks, and the needs of the system tests, without a guest."""

from __future__ import annotations

import pytest

from tests.system import needs
from tests.system.gpio.report import Report
from tests.texts import CheckText

BEGUN, PASSED = '{"begun": "motors: a stop"}', '{"passed": "motors: a stop"}'
FAILED = '{"failed": "motors: a stop", "why": "assert [17] == []"}'
ENDED = '{"ended": "0"}'


def read_report(*lines: str) -> Report:
    report = Report()
    report.read(lines)
    return report


def test_the_report_is_passed_if_all_checks_passed_and_the_guest_ended(capsys: pytest.CaptureFixture[str]) -> None:
    assert read_report("noise of the firmware", BEGUN, PASSED, ENDED).is_passed
    assert capsys.readouterr().out == "ok      motors: a stop\n"


def test_a_failed_check_is_reported_with_its_values(capsys: pytest.CaptureFixture[str]) -> None:
    assert not read_report(BEGUN, FAILED, ENDED).is_passed
    assert capsys.readouterr().out == "not ok  motors: a stop\n          assert [17] == []\n"


def test_a_check_that_hangs_is_reported(capsys: pytest.CaptureFixture[str], check_text: CheckText) -> None:
    assert not read_report(BEGUN).is_passed
    check_text(capsys.readouterr().out)


def test_a_guest_that_does_not_start_is_a_failure(capsys: pytest.CaptureFixture[str], check_text: CheckText) -> None:
    assert not read_report().is_passed
    check_text(capsys.readouterr().out)


def test_a_test_that_cannot_run_prints_the_reason_and_has_its_own_exit_status(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def lacking() -> bool:
        raise needs.NotRunError("needs root")

    assert needs.run_or_skip("gpio", lacking) == needs.NOT_RUN
    assert capsys.readouterr().out == "gpio: not run: needs root\n"


def test_a_user_other_than_root_is_refused(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    monkeypatch.setattr("platform.freedesktop_os_release", lambda: {"ID": "debian", "VERSION_ID": "12"})
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    with pytest.raises(needs.NotRunError) as raised:
        needs.debian()
    check_text(raised.value)


def test_another_system_is_refused(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    other = {"ID": "ubuntu", "VERSION_ID": "24.04", "PRETTY_NAME": "Ubuntu 24.04"}
    monkeypatch.setattr("platform.freedesktop_os_release", lambda: other)
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    with pytest.raises(needs.NotRunError) as raised:
        needs.debian()
    check_text(raised.value)


def test_a_package_that_cannot_be_installed_is_reported_with_apt_s_error(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("tests.system.needs._is_installed", lambda name: name != "qemu-system-x86")
    monkeypatch.setattr("tests.system.needs._apt", lambda *_: "E: Unable to fetch some archives")
    with pytest.raises(needs.NotRunError) as raised:
        needs.packages("qemu-system-x86", "kmod")
    check_text(raised.value)

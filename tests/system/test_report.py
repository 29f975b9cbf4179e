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


def test_a_failed_check_is_told_with_what_was_got_and_expected(capsys: pytest.CaptureFixture[str]) -> None:
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

    assert needs.told("gpio", lacking) == needs.NOT_RUN
    assert capsys.readouterr().out == "gpio: not run: needs root\n"

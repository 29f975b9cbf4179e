"""test_finding."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from robotcore.hal.finding import Finding, Level, findings_of


def fine() -> Iterator[Finding]:
    yield Finding.ok("disk", "empty")


def failing() -> Iterator[Finding]:
    yield Finding.ok("camera", "is there")
    raise PermissionError(13, "Permission denied", "/dev/video0")


def test_a_check_that_fails_keeps_none_from_being_made_nor_takes_back_what_it_found() -> None:
    found = list(findings_of([("camera", failing), ("disk", fine)]))
    assert [(each.what, each.level) for each in found] == [
        ("camera", Level.OK),
        ("camera", Level.WARNING),
        ("disk", Level.OK),
    ]
    assert found[1].said == "could not be checked: /dev/video0: Permission denied"


@pytest.mark.parametrize(
    "error, answer", [(KeyError("gpio"), "KeyError: 'gpio'"), (AssertionError(), "AssertionError")]
)
def test_an_error_that_says_little_is_reported_by_its_kind(error: Exception, answer: str) -> None:
    def broken() -> Iterator[Finding]:
        raise error
        yield

    assert [each.said for each in findings_of([("disk", broken)])] == [f"could not be checked: {answer}"]

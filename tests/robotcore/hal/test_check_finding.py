from __future__ import annotations

from collections.abc import Iterator

import pytest

from robotcore.hal.check_finding import Finding, Level, findings_of
from tests.texts import CheckText


def fine() -> Iterator[Finding]:
    yield Finding.ok("disk", "empty", kind="disk-empty")


def failing() -> Iterator[Finding]:
    yield Finding.ok("camera", "is there", kind="camera-found")
    raise PermissionError(13, "Permission denied", "/dev/video0")


def test_a_failing_check_keeps_its_findings_and_the_next_check_is_made(check_text: CheckText) -> None:
    found = list(findings_of([("camera", failing), ("disk", fine)]))
    assert [(each.subject, each.level) for each in found] == [
        ("camera", Level.OK),
        ("camera", Level.WARNING),
        ("disk", Level.OK),
    ]
    assert found[1].kind == "unchecked"
    check_text(found[1].message)


@pytest.mark.parametrize("error", [KeyError("gpio"), AssertionError()], ids=["KeyError", "AssertionError"])
def test_an_exception_with_a_short_text_is_named_by_its_class(error: Exception, check_text: CheckText) -> None:
    def broken() -> Iterator[Finding]:
        raise error
        yield

    (finding,) = findings_of([("disk", broken)])
    check_text(finding.message)

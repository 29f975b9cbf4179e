from __future__ import annotations

from datetime import datetime, timedelta, timezone

import pytest

from robotcore.junit import JUnitCase, JUnitSuite, Problem, ProblemElement, format_junit
from tests.robotcore.junit_schema import read_junit


def test_suites_have_the_form_and_the_counts_that_readers_expect() -> None:
    cases = [JUnitCase("search.open", "fine", 1.25, output="all is well")]
    cases += [
        JUnitCase("search.open", verdict.value, 0.5, Problem(verdict, "timeout", "too late", "a\nb"))
        for verdict in ProblemElement
    ]
    date = datetime(2026, 11, 25, 1, 30, tzinfo=timezone(timedelta(hours=1)))
    root = read_junit(format_junit([JUnitSuite("one", cases, {"robot": "rover"}, date), JUnitSuite("two", [])]))
    first, second = root
    expected = {"tests": "4", "failures": "1", "errors": "1", "skipped": "1", "time": "2.750"}
    assert first.attrib == expected | {"name": "one", "timestamp": "2026-11-25T00:30:00"}
    assert second.attrib == {
        "name": "two",
        "tests": "0",
        "failures": "0",
        "errors": "0",
        "skipped": "0",
        "time": "0.000",
    }
    failure = first.find("testcase/failure")
    assert failure is not None
    assert (failure.attrib, failure.text) == ({"type": "timeout", "message": "too late"}, "a\nb")
    assert first.findtext("testcase/system-out") == "all is well"


@pytest.mark.parametrize(
    "hostile, shown",
    [
        ("]]> <failure/> & \"'", "]]> <failure/> & \"'"),
        ("\x00\x08\x1b[31m\x7f\x85", r"\x00\x08\x1b[31m\x7f\x85"),
        ("\ud800 \udcff", r"\ud800 \udcff"),
        ("\ufffe\uffff\u202e", r"\ufffe\uffff\u202e"),
        ("\r", r"\r"),
        ("grün 🤖", "grün 🤖"),
    ],
)
def test_hostile_text_does_not_break_the_file(hostile: str, shown: str) -> None:
    problem = Problem(ProblemElement.ERROR, hostile, hostile, f"{hostile}\nend")
    case = JUnitCase(hostile, hostile, problem=problem, output=hostile)
    root = read_junit(format_junit([JUnitSuite(hostile, [case], {hostile: hostile})]))
    texts = [
        value for element in root.iter() for key, value in element.attrib.items() if key in ("name", "value", "message")
    ]
    assert texts == ["robotcore", *[shown] * 5]
    assert root.findtext(".//error") == f"{shown}\nend"
    assert root.findtext(".//system-out") == shown


def test_a_line_break_in_a_name_is_escaped() -> None:
    root = read_junit(format_junit([JUnitSuite("a", [JUnitCase("b", "two\nlines")])]))
    assert root[0][0].attrib["name"] == r"two\nlines"

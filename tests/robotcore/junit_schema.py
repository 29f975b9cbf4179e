"""Check that XML has the form that readers of JUnit files accept: the rules of the schema junit-10.xsd of Jenkins."""

from __future__ import annotations

import re
from typing import NamedTuple
from xml.etree import ElementTree as ET


class Form(NamedTuple):
    """What the schema allows in an element."""

    required: frozenset[str]
    """The attributes that it must have."""
    optional: frozenset[str] = frozenset()
    """The attributes that it may have."""
    children: frozenset[str] = frozenset()
    """The elements that may be in it."""
    has_text: bool = False
    """Whether it may have text."""


COUNTS = frozenset({"tests", "failures", "errors"})
CAUSE = Form(frozenset(), frozenset({"type", "message"}), has_text=True)
FORMS = {
    "testsuites": Form(frozenset(), COUNTS | {"name", "time"}, frozenset({"testsuite"})),
    "testsuite": Form(
        COUNTS | {"name"},
        frozenset({"time", "skipped", "timestamp", "hostname", "id", "package", "file", "log", "url", "group"}),
        frozenset({"testsuite", "properties", "testcase", "system-out", "system-err"}),
    ),
    "properties": Form(frozenset(), children=frozenset({"property"})),
    "property": Form(frozenset({"name", "value"})),
    "testcase": Form(
        frozenset({"name"}),
        frozenset({"time", "classname", "group"}),
        frozenset({"skipped", "error", "failure", "system-out", "system-err"}),
    ),
    "skipped": CAUSE,
    "error": CAUSE,
    "failure": CAUSE,
    "system-out": Form(frozenset(), has_text=True),
    "system-err": Form(frozenset(), has_text=True),
}
TIME = re.compile(r"\d{1,9}\.\d{3}")


def read_junit(content: bytes) -> ET.Element:
    """Return the root of a JUnit file. Raises AssertionError if its form, its counts or its names are wrong."""
    root = ET.fromstring(content)  # noqa: S314  the code under test has written it
    assert root.tag == "testsuites"
    for element in root.iter():
        _check_form(element)
    suites = root.findall("testsuite")
    for suite in suites:
        cases = suite.findall("testcase")
        counts = {"tests": len(cases), "skipped": _count(cases, "skipped")}
        counts |= {f"{verdict}s": _count(cases, verdict) for verdict in ("failure", "error")}
        assert {key: int(suite.attrib[key]) for key in counts} == counts
    assert {key: int(root.attrib[key]) for key in COUNTS} == {
        key: sum(int(suite.attrib[key]) for suite in suites) for key in COUNTS
    }
    names = [case.attrib["name"] for case in root.iter("testcase")]
    assert len(set(names)) == len(names), "GitLab ignores the second of two cases with one name"
    return root


def _check_form(element: ET.Element) -> None:
    form = FORMS[element.tag]
    assert form.required <= element.attrib.keys() <= form.required | form.optional, element.tag
    assert {child.tag for child in element} <= form.children, element.tag
    assert form.has_text or not (element.text or "").strip(), element.tag
    assert TIME.fullmatch(element.get("time", "0.000"))
    if timestamp := element.get("timestamp"):
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", timestamp)


def _count(cases: list[ET.Element], verdict: str) -> int:
    return sum(case.find(verdict) is not None for case in cases)

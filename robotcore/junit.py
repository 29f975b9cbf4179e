"""JUnit XML: the results of a command as test suites, which the readers of CI servers show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from enum import Enum
from xml.etree import ElementTree as ET

from robotcore.errors import BehaviourError, RobotcoreError
from robotcore.text import escape


class ProblemElement(str, Enum):
    """The XML element of a case that did not pass. The value is its name."""

    FAILURE = "failure"
    """The case checked something, and the check failed."""
    ERROR = "error"
    """The case could not check, because something was broken."""
    SKIPPED = "skipped"
    """The case does not count, for example because a failure was expected."""


@dataclass(frozen=True)
class Problem:
    """The element of a case that did not pass, and the cause."""

    verdict: ProblemElement

    kind: str
    """A stable identifier of the cause, such as ``timeout``."""

    message: str
    """The cause in one line."""

    details: str = ""
    """The cause in full, and the command that repeats the case. It may have several lines."""


@dataclass(frozen=True)
class JUnitCase:
    """A test case: a thing that was checked, and how the check ended."""

    group: str
    """The dotted name under which readers list the case: its ``classname``."""

    name: str
    """The name of the case. Some readers ignore the second of two cases with one name, so it is unique in the file."""

    time_s: float = 0.0
    """The duration in real time, in seconds."""

    problem: Problem | None = None
    """Why the case did not pass; None if it passed."""

    output: str = ""
    """Text that readers show with the case. It may have several lines."""


@dataclass(frozen=True)
class JUnitSuite:
    """A test suite: cases that belong together.

    >>> print(format_junit([JUnitSuite("walls", [JUnitCase("avoid.open", "seed 7", 1.5)])]).decode())
    <?xml version='1.0' encoding='utf-8'?>
    <testsuites name="robotcore" tests="1" failures="0" errors="0" time="1.500">
      <testsuite name="walls" tests="1" failures="0" errors="0" time="1.500" skipped="0">
        <testcase classname="avoid.open" name="seed 7" time="1.500" />
      </testsuite>
    </testsuites>
    <BLANKLINE>
    """

    name: str

    cases: Sequence[JUnitCase]

    properties: Mapping[str, str] = field(default_factory=dict)
    """Facts about the suite, such as the name of the robot."""

    date: datetime | None = None
    """The time of the results, with its time zone; None if it is unknown."""


def build_error_suite(group: str, name: str, command: str, error: RobotcoreError) -> JUnitSuite:
    """Return a suite with one case, which could not check anything because of an error.

    group: the group of the case.
    name: the name of the case.
    command: the command line that repeats it.
    """
    case = JUnitCase(group, name, problem=build_error_problem(error, command))
    return JUnitSuite(f"{group} of {name}", [case], {"command": command})


def build_error_problem(error: RobotcoreError, command: str) -> Problem:
    """Return an error as the problem of a case, with the traceback of an app's error.

    command: the command line that repeats the case.
    """
    trace = error.traceback if isinstance(error, BehaviourError) else ""
    text = "\n".join(part for part in (str(error), trace) if part)
    first = str(error).partition("\n")[0]
    return Problem(ProblemElement.ERROR, error.kind, first, f"{text}\n\nRepeat the command: {command}")


def format_junit(suites: Sequence[JUnitSuite]) -> bytes:
    """Return suites as the content of an XML file in UTF-8.

    The file is valid by the schema junit-10.xsd of Jenkins, and its names are those that GitLab reads. XML 1.0 has no
    control characters and no surrogates, so they are escaped with a backslash.
    """
    root = ET.Element(
        "testsuites",
        {"name": "robotcore", **_build_count_attributes([each for suite in suites for each in suite.cases])},
    )
    for suite in suites:
        _add_suite(root, suite)
    ET.indent(root)
    content: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _add_suite(root: ET.Element, suite: JUnitSuite) -> None:
    element = ET.SubElement(root, "testsuite", {"name": escape(suite.name), **_build_count_attributes(suite.cases)})
    element.set(
        "skipped", str(_count_verdict(suite.cases, ProblemElement.SKIPPED))
    )  # the schema has it for suites only
    if suite.date:
        element.set("timestamp", suite.date.astimezone(timezone.utc).strftime("%Y-%m-%dT%H:%M:%S"))
    if suite.properties:
        properties = ET.SubElement(element, "properties")
        for name, value in suite.properties.items():
            ET.SubElement(properties, "property", name=escape(name), value=escape(value))
    for case in suite.cases:
        _add_case(element, case)


def _add_case(suite: ET.Element, case: JUnitCase) -> None:
    names = {"classname": escape(case.group), "name": escape(case.name)}
    element = ET.SubElement(suite, "testcase", names, time=_format_time(case.time_s))
    if problem := case.problem:
        cause = {"type": escape(problem.kind), "message": escape(problem.message)}
        ET.SubElement(element, problem.verdict.value, cause).text = escape(problem.details, keep="\n") or None
    if case.output:
        ET.SubElement(element, "system-out").text = escape(case.output, keep="\n")


def _build_count_attributes(cases: Sequence[JUnitCase]) -> Mapping[str, str]:
    """Return the attributes that count cases and add up their durations."""
    return {
        "tests": str(len(cases)),
        "failures": str(_count_verdict(cases, ProblemElement.FAILURE)),
        "errors": str(_count_verdict(cases, ProblemElement.ERROR)),
        "time": _format_time(sum(case.time_s for case in cases)),
    }


def _count_verdict(cases: Sequence[JUnitCase], verdict: ProblemElement) -> int:
    return sum(case.problem is not None and case.problem.verdict is verdict for case in cases)


def _format_time(time_s: float) -> str:
    return f"{time_s:.3f}"

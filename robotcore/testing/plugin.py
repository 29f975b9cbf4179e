"""The pytest plug-in of the conformance kit: it registers the marker, and lists the skipped rules."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

MARKER = "conformance"

UNMEASURED_MOTION = (
    "nothing measures the robot's motion: there is no truth, there are no encoders, and the suite does not override "
    "measure_pose()"
)
"""The reason of a skipped rule that cannot measure the robot's motion."""


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker of the conformance rules."""
    config.addinivalue_line("markers", f"{MARKER}: a rule of robotcore's conformance kit")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List the skipped conformance rules at the end of pytest's output, sorted by suite and reason."""
    rules: dict[str, list[str]] = {}
    for suite, rule, reason in _list_skipped(terminalreporter):
        rules.setdefault(f"{suite}: {reason}", []).append(rule)
    if rules:
        terminalreporter.section("conformance rules not checked")
    for heading, names in rules.items():
        terminalreporter.line(f"{heading}\n    {', '.join(names)}")


def pytest_unconfigure(config: pytest.Config) -> None:
    """Warn in the last line of pytest's output, after the counts, if nothing measures the motion of a robot."""
    reporter: pytest.TerminalReporter | None = config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None:
        return
    skipped = [suite for suite, _, reason in _list_skipped(reporter) if reason == UNMEASURED_MOTION]
    if skipped:
        suites = ", ".join(dict.fromkeys(skipped))
        reporter.write_line(
            f"WARNING: {suites}: {len(skipped)} conformance rules cannot measure the robot's motion, so a robot that "
            "drives backward passes. Override measure_pose() in the suite",
            yellow=True,
        )


def _list_skipped(reporter: pytest.TerminalReporter) -> list[tuple[str, str, str]]:
    """Return the suite, the name and the reason of each skipped rule."""
    skipped = [report for report in reporter.getreports("skipped") if MARKER in getattr(report, "keywords", ())]
    return [(*_split_name(report.nodeid), _get_reason(report)) for report in skipped]


def _split_name(nodeid: str) -> tuple[str, str]:
    suite, rule = nodeid.split("::")[-2:]
    return suite, rule.removeprefix("test_")


def _get_reason(report: pytest.TestReport | pytest.CollectReport) -> str:
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return reason.removeprefix("Skipped: ")

"""The pytest plug-in of the conformance kit: it registers the marker, and lists the skipped rules."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

MARKER = "conformance"


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker of the conformance rules."""
    config.addinivalue_line("markers", f"{MARKER}: a rule of robotcore's conformance kit")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List the skipped conformance rules at the end of pytest's output, sorted by reason."""
    skipped = [report for report in terminalreporter.getreports("skipped") if MARKER in report.keywords]
    if not skipped:
        return
    terminalreporter.section("conformance rules not checked")
    rules: dict[str, list[str]] = {}
    for report in skipped:
        suite, rule = report.nodeid.split("::")[-2:]
        rules.setdefault(f"{suite}: {_reason(report)}", []).append(rule.removeprefix("test_"))
    for reason, names in rules.items():
        terminalreporter.line(f"{reason}\n    {', '.join(names)}")


def _reason(report: pytest.TestReport | pytest.CollectReport) -> str:
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return reason.removeprefix("Skipped: ")

"""A plug-in for pytest that tells the host of every check, as JSON, line by line."""

from __future__ import annotations

import json
import os
import tty

import pytest


class Telling:
    """Writes which check has begun, and what came of it, to the port that the host reads."""

    def __init__(self, port: int) -> None:
        self._port = port

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._tell(begun=_words(nodeid))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        name = _words(report.nodeid)
        if report.failed:
            self._tell(failed=name if report.when == "call" else f"{name} ({report.when})", why=_why(report))
        elif report.skipped:
            self._tell(skipped=name, why=_why(report))
        elif report.when == "call":
            self._tell(passed=name)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self._tell(failed=_words(report.nodeid), why=_why(report))

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        self._tell(ended=str(int(exitstatus)))

    def _tell(self, **event: str) -> None:
        os.write(self._port, json.dumps(event).encode() + b"\n")


def pytest_configure(config: pytest.Config) -> None:
    port = os.open(os.environ["CHECKS_TOLD"], os.O_WRONLY | os.O_NOCTTY)
    tty.setraw(port)
    config.pluginmanager.register(Telling(port))


def _words(nodeid: str) -> str:
    """Return a check's name as it is told: its file, and what it shows.

    >>> _words("tests/system/guest/motors.py::test_stop_leaves_both_pins_low")
    'motors: stop leaves both pins low'
    """
    file, _, name = nodeid.partition("::")
    return f"{file.rpartition('/')[2].removesuffix('.py')}: {name.removeprefix('test_').replace('_', ' ')}"


def _why(report: pytest.TestReport | pytest.CollectReport) -> str:
    """Return what was got and expected, without the lines that led there."""
    crash = getattr(report.longrepr, "reprcrash", None)
    if crash:
        return str(crash.message)
    return str(report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext)

"""A plug-in for pytest that sends the result of every check to the host, as lines of JSON."""

from __future__ import annotations

import json
import os
import tty

import pytest


class Reporter:
    """Writes the beginning and the result of each check to the serial port that the host reads."""

    def __init__(self, port: int) -> None:
        self._port = port

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._send(begun=_title(nodeid))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        name = _title(report.nodeid)
        if report.failed:
            self._send(failed=name if report.when == "call" else f"{name} ({report.when})", why=_why(report))
        elif report.skipped:
            self._send(skipped=name, why=_why(report))
        elif report.when == "call":
            self._send(passed=name)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self._send(failed=_title(report.nodeid), why=_why(report))

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        self._send(ended=str(int(exitstatus)))

    def _send(self, **event: str) -> None:
        os.write(self._port, json.dumps(event).encode() + b"\n")


def pytest_configure(config: pytest.Config) -> None:
    port = os.open(os.environ["CHECKS_PORT"], os.O_WRONLY | os.O_NOCTTY)
    tty.setraw(port)
    config.pluginmanager.register(Reporter(port))


def _title(nodeid: str) -> str:
    """Return the title of a check: its file and its name as words.

    >>> _title("tests/system/guest/motors.py::test_stop_leaves_both_pins_low")
    'motors: stop leaves both pins low'
    """
    file, _, name = nodeid.partition("::")
    return f"{file.rpartition('/')[2].removesuffix('.py')}: {name.removeprefix('test_').replace('_', ' ')}"


def _why(report: pytest.TestReport | pytest.CollectReport) -> str:
    """Return the actual and the expected value, without the traceback."""
    crash = getattr(report.longrepr, "reprcrash", None)
    if crash:
        return str(crash.message)
    return str(report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext)

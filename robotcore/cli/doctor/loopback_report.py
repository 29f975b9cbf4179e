"""The report of a loopback test, as a file that the owner of a Pi can send: versions, values and verdicts only."""

from __future__ import annotations

import getpass
import json
import os
import platform
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal
from urllib.parse import quote

from pydantic import BaseModel, ConfigDict, Field, field_validator

from robotcore.compatibility import read_version
from robotcore.description.file_reading import read_limited
from robotcore.errors import UsageError
from robotcore.files import save_output
from robotcore.text import escape

if TYPE_CHECKING:
    from robotcore.hal.loopback import LoopbackRequest, RuleResult

FORMAT = 1
COMPLETE = "complete"
"""The value of ``ended`` of a test that reached its end."""

UNFINISHED = "the program ended before the test"
"""The value of ``ended`` while the test runs. It stays if the program is killed."""

HIDDEN = "…"
_FILE = re.compile(r"[\w./~-]+\.(?:toml|py|json)\b")
_PATH = re.compile(r"(?<![\w.…])(?:~[\w.-]*)?/(?!dev/(?!serial/)|proc/(?!\d)|sys/|etc/|boot/)[^\s:;,'\"()]+")
_ADDRESS = re.compile(
    r"(?<![\w.])\d{2,3}(?:\.\d{1,3}){3}(?![\w.])|(?<![\w:])(?:[0-9a-fA-F]{1,4}::?){2,7}[0-9a-fA-F]{1,4}(?![\w:])"
)
"""Matches IPv4, IPv6 and MAC addresses."""

_SERIAL_NUMBER = re.compile(r"(?<![\w.])(?=[a-fA-F]*\d)[0-9a-fA-F]{12,}\b")
_PROCESS = re.compile(r"process \d+(?: \(.*\))?")
OPTION = "--report"


def hide_private(text: str) -> str:
    """Return a text without paths, programs, addresses, serial numbers, and the names of the host and the user.

    >>> hide_private("GPIO 17 is held by process 812 (my_robot)")
    'GPIO 17 is held by another program'
    """
    text = _PROCESS.sub("another program", text)
    for private in (_PATH, _FILE, _ADDRESS, _SERIAL_NUMBER):
        text = private.sub(HIDDEN, text)
    for name in {platform.node(), platform.node().partition(".")[0], _find_user()} - {""}:
        text = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", HIDDEN, text)
    return text


def _find_user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a user without a name
        return ""


def build_default_name(now: datetime) -> Path:
    """Return the file name of a report. It has the host's name, for the owner; the file's content has not."""
    host = re.sub(r"[^\w-]", "-", platform.node().partition(".")[0]) or "pi"
    return Path(f"robotcore-{host}-{now:%Y-%m-%d-%H%M}.json")


class LoopbackReport:
    """The results of a loopback test, and the facts about the machine.

    board: the backend's facts about the board.
    rules: the identifiers of all rules.
    """

    def __init__(
        self, request: LoopbackRequest, wires: Iterable[tuple[int, int]], board: Mapping[str, str], rules: Iterable[str]
    ) -> None:
        self._facts = {
            "date": f"{datetime.now(timezone.utc):%Y-%m-%d}",
            "robotcore": read_version(),
            "python": platform.python_version(),
            "kernel": hide_private(platform.release()),
            "machine": platform.machine(),
            "os": _find_system(),
            "processors": os.cpu_count() or 0,
            "board": {name: hide_private(text) for name, text in board.items()},
        }
        self._options = {
            "wires": [list(wire) for wire in wires],
            "rt": request.is_real_time,
            "tick_test_s": request.tick_test_s,
            "has_robot": request.robot is not None,
        }
        self._rules = tuple(rules)
        self.results: list[RuleResult] = []
        self.ended = UNFINISHED

    def end(self, reason: str) -> None:
        """Set how the test ended. The rules without a result are skipped."""
        from robotcore.hal.loopback import RuleResult

        self.ended = hide_private(reason)
        done = {result.rule for result in self.results}
        self.results += [RuleResult.skip(rule, f"not reached: {reason}") for rule in self._rules if rule not in done]

    def count(self, verdict: str) -> int:
        """Return the number of rules with a verdict."""
        return Counter(result.verdict.value for result in self.results)[verdict]

    @property
    def exit_status(self) -> int:
        """Return 0 if the test reached its end, and no rule failed."""
        return int(self.ended != COMPLETE or self.count("failed") > 0)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as data for JSON.

        The JSON keys:

        format: whole number; the version of the report's format.
        ended: text; ``complete``, or why the test ended before.
        date: text; the date in UTC, such as ``2026-11-25``.
        robotcore: text; the version of robotcore.
        python: text; the version of Python.
        kernel: text; the version of the kernel.
        machine: text; the processor, such as ``aarch64``.
        os: text; the operating system.
        processors: whole number; the number of processor cores.
        board: object of text; facts about the board, such as its ``model`` and the versions of its libraries.
        options: object; the options of the test.
        options.wires: list of lists of two numbers; the GPIOs of each wire, output and input.
        options.rt: true or false; whether ``--rt`` was given.
        options.tick_test_s: number, s; the duration of each measurement of the ticks.
        options.has_robot: true or false; whether ``--robot`` was given.
        passed: whole number; the number of rules that passed.
        failed: whole number; the number of rules that failed.
        skipped: whole number; the number of rules that the test skipped.
        rules: list of objects; the results of the rules.
        rules[].*: robotcore.hal.loopback.RuleResult
        exit_status: whole number; the exit status.
        """
        return {
            "format": FORMAT,
            "ended": self.ended,
            **self._facts,
            "options": self._options,
            **{verdict: self.count(verdict) for verdict in ("passed", "failed", "skipped")},
            "rules": [self._format_result(result) for result in self.results],
            "exit_status": self.exit_status,
        }

    @staticmethod
    def _format_result(result: RuleResult) -> dict[str, Any]:
        texts = {name: hide_private(getattr(result, name)) for name in ("measured", "bound", "reason")}
        return {**asdict(result), "verdict": result.verdict.value, **texts}

    def save(self, file: Path) -> None:
        """Write the report. Raises UsageError if that fails."""
        content = json.dumps(self.to_dict(), indent=1, ensure_ascii=False) + "\n"
        save_output(content.encode(), file, OPTION)


def _find_system() -> str:
    try:
        return platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    except OSError:
        return platform.system()


MAX_REPORT_BYTES = 1_000_000

_Text = Annotated[str, Field(max_length=200)]
_Value = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]


class _Rule(BaseModel):
    model_config = ConfigDict(extra="ignore")

    rule: _Text
    verdict: Literal["passed", "failed", "skipped"]
    values: dict[str, _Value] = Field(default_factory=dict)

    @field_validator("values")
    @classmethod
    def _require_durations(cls, values: dict[str, float]) -> dict[str, float]:
        if any(name.endswith("_ms") and value < 0 for name, value in values.items()):
            raise ValueError("a duration is negative")
        return values


class _Board(BaseModel):
    model: _Text = ""


class _SavedReport(BaseModel):
    """The part of a report's file that a row needs."""

    model_config = ConfigDict(extra="ignore")

    format: int = Field(strict=True, ge=FORMAT, le=FORMAT)
    ended: _Text
    robotcore: _Text
    os: _Text
    board: _Board
    rules: list[_Rule] = Field(max_length=1000)

    @field_validator("rules")
    @classmethod
    def _require_unique_names(cls, rules: list[_Rule]) -> list[_Rule]:
        if len({rule.rule for rule in rules}) < len(rules):
            raise ValueError("a rule has two results")
        return rules


STOPS = ("command", "deadman", "sigterm", "sigkill", "guardian")


def format_row(file: Path) -> str:
    """Return the row of a report for the table in the QUALITY.md of a driver.

    The report may be another person's. Its texts are escaped. Raises UsageError for a file that is no report.
    """
    content = read_limited(file, MAX_REPORT_BYTES)
    try:
        report = _SavedReport.model_validate_json(content)
    except ValueError as error:  # also the ValidationError of pydantic
        text = f"--row {file}: the file is no report of format {FORMAT}. Name a report of robotcore doctor --loopback"
        raise UsageError(text, kind="no-report", file=str(file)) from error
    values = {rule.rule: rule.values for rule in report.rules}
    worst = " / ".join(_format_ms(values.get(f"ticks-{rate}hz", {})) for rate in (20, 50))
    stops = " / ".join(_format_ms(values.get(f"stop-{stop}", {})) for stop in STOPS)
    counts = Counter(rule.verdict for rule in report.rules)
    ended = "" if report.ended == COMPLETE else ", not complete"
    cells = (
        _escape_markdown(report.board.model) or "unknown",
        _escape_markdown(report.os),
        _escape_markdown(report.robotcore),
        f"{counts['passed']} / {counts['failed']} / {counts['skipped']}{ended}",
        worst,
        stops,
        f"[report](reports/{quote(file.name)})",
    )
    return f"| {' | '.join(cells)} |"


def _escape_markdown(text: str) -> str:
    """Return a text with escapes, so that it makes no link, mention or formula in a Markdown table."""
    escaped = re.sub(r"([\\`*_\[\]<>&~|:$]|(?<=www)\.)", r"\\\1", escape(text), flags=re.IGNORECASE)
    return re.sub("([@#])", r"\1<!-- -->", escaped)  # GitHub finds @name and #1 after it has removed the escapes


def _format_ms(values: Mapping[str, float]) -> str:
    return f"{values['worst_ms']:.1f}" if "worst_ms" in values else "–"

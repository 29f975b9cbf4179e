"""``robotcore doctor --loopback`` tests a board over wires between its own pins, and writes a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import closing, suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.doctor.loopback_report import COMPLETE, OPTION, LoopbackReport, build_default_name
from robotcore.cli.output import redirect_prints, write_json, write_line
from robotcore.cli.person import TerminalPerson, has_terminal
from robotcore.errors import Interrupted, RobotcoreError, UnknownNameError, UsageError
from robotcore.files import require_writable
from robotcore.text import escape

if TYPE_CHECKING:
    from robotcore.hal.loopback import LoopbackRequest, LoopbackTest, RuleResult
    from robotcore.runtime.signals import SignalGuard

DEFAULT_BACKEND = "raspberrypi"
READY = "ready"
STYLES = {"passed": "green", "failed": "red", "skipped": "yellow"}


class AnsweringLoopbackPerson:
    """The person at the terminal, with answers that were given on the command line.

    answers: the answers by their topics.
    """

    def __init__(self, answers: Mapping[str, str]) -> None:
        self._person, self._answers = TerminalPerson(), answers

    def confirm(self, topic: str, instruction: str) -> bool:
        if (given := self._answers.get(topic)) is not None:
            return given == READY
        return self._person.confirm(f"{topic}: {instruction}")

    def choose(self, topic: str, question: str, choices: Mapping[str, str]) -> str | None:
        if (given := self._answers.get(topic)) is not None:
            return given
        return self._person.choose(f"{topic}: {question}?", choices)


def run_loopback(
    backend: str | None,
    request: LoopbackRequest,
    answers: Iterable[tuple[str, str]],
    file: Path | None,
    *,
    as_json: bool,
) -> int:
    """Run the loopback test of a backend, and write its report. Return the exit status.

    answers: pairs of a topic and an answer.
    file: the report's file; None for a name with host and date.
    """
    from robotcore.hal.backend import load_backend
    from robotcore.runtime.signals import SignalGuard

    test = load_backend(backend or DEFAULT_BACKEND).plan_loopback(request)
    given = _check_answers(test, answers)
    if "wires" not in given and not has_terminal():
        text = "no terminal to ask you to connect the wires. Run the command in a terminal, or add --answer wires=ready"
        raise UsageError(text, kind="not-confirmed")
    file = file or build_default_name(datetime.now())  # noqa: DTZ005  the owner's local time
    require_writable(file, OPTION)
    report = LoopbackReport(request, test.pins, test.describe_board(), test.rules)
    with SignalGuard() as signals, redirect_prints(as_json=as_json):
        _measure(test, AnsweringLoopbackPerson(given), report, file, signals, as_json=as_json)
    if as_json:
        write_json(_build_answer(report, file))
    else:
        _write_end(report, file)
    return report.exit_status


def _build_answer(report: LoopbackReport, file: Path) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore doctor --loopback``.

    The JSON keys:

    *: robotcore.cli.doctor.loopback_report.LoopbackReport.to_dict
    report: text; the file of the report.
    """
    return {**report.to_dict(), "report": str(file)}


def _measure(
    test: LoopbackTest,
    person: AnsweringLoopbackPerson,
    report: LoopbackReport,
    file: Path,
    signals: SignalGuard,
    *,
    as_json: bool,
) -> None:
    """Run the test, and write the report after each result, so that an interrupted test has a report too."""

    def write(text: str) -> None:
        write_line(text, is_error=True)

    try:
        with closing(test.run(person, write)) as results:
            for result in results:
                report.results.append(result)
                report.save(file)
                if not as_json:
                    _write_result(result)
                signals.check()  # Python discards the exception of a signal in a callback, such as of a weak reference
        report.end(COMPLETE)
        report.save(file)
    except (Exception, Interrupted) as error:
        cause = signals.raised or error  # a library may raise an error of its own in place of the signal's
        if not isinstance(cause, (RobotcoreError, Interrupted)):
            raise
        report.end(str(cause))
        report.save(file)
        write(f"The test did not reach its end. The partial report: {file}")
        if cause is error:
            raise
        raise cause from None


def _check_answers(test: LoopbackTest, answers: Iterable[tuple[str, str]]) -> dict[str, str]:
    known = test.topics
    for topic, answer in answers:
        if topic not in known:
            raise UnknownNameError("topic", topic, list(known))
        if answer not in known[topic]:
            text = f"--answer {topic}={answer}: the answers are {', '.join(known[topic])}. Take one of them"
            raise UsageError(text, kind="unknown-answer", topic=topic, answer=answer)
    return dict(answers)


def _write_result(result: RuleResult) -> None:
    verdict = result.verdict.value
    text = f"{result.measured} ({result.bound})" if result.measured else result.reason
    styled = click.style(f"{verdict:<8}", fg=STYLES[verdict])
    with suppress(OSError):  # the terminal is closed; the report is in the file
        write_line(f"{styled} {result.rule:<18} {escape(text)}", is_styled=True)
        if result.measured and result.reason and result.reason != result.measured:
            write_line(f"{'→':>27} {result.reason}")


def _write_end(report: LoopbackReport, file: Path) -> None:
    write_line()
    write_line(f"{report.count('passed')} passed, {report.count('failed')} failed, {report.count('skipped')} skipped")
    write_line(f"The report: {file}. robotcore has removed the private parts that it recognises: the host's name, the")
    write_line("user's name, serial numbers, addresses and paths.")
    write_line(
        'Read it, and send it as the section "Test your Pi" describes, in the page "From a box of parts to a robot"'
    )
    write_line("of the documentation.")

"""The result of a replay as a JUnit test suite with one case: the recording."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path

from robotcore.errors import BehaviourError, RobotcoreError
from robotcore.junit import JUnitCase, JUnitSuite, Problem, Verdict
from robotcore.recording.replay import Evaluation, ReplayResult
from robotcore.view.text import list_differences, list_findings

DEVIATION = "deviation"
"""The kind of the problem of a decision that differs from the recorded one."""

CHANGED = "recording-changed"
"""The kind of the problem of a recording whose digest is not that of its decisions."""

_NAME = "replay"


def build_suite(file: Path, command: str, ended: ReplayResult | Evaluation | RobotcoreError) -> JUnitSuite:
    """Return a suite whose only case is a recording.

    file: the recording.
    command: the command line of the replay, which repeats it.
    ended: the result of the replay, or the error because of which there is none.

    The case passes if the exit status of the command is 0.
    """
    if isinstance(ended, RobotcoreError):
        case = JUnitCase(_NAME, str(file), problem=_build_error(ended, command))
    else:
        lines = list(list_findings(ended) if isinstance(ended, ReplayResult) else list_differences(ended))
        problem = _find_problem(ended, lines, command)
        output = "" if problem else "\n".join(lines)
        case = JUnitCase(_NAME, str(file), ended.result.wall_time_s, problem, output)
    facts = {"command": command, "robotcore": version("robotcore")}
    return JUnitSuite(f"{_NAME} of {file}", [case], facts)


def _find_problem(ended: ReplayResult | Evaluation, lines: list[str], command: str) -> Problem | None:
    if not ended.exit_status:
        return None
    if isinstance(ended, Evaluation) and isinstance(ended.result.error, RobotcoreError) and not ended.is_at_end:
        return _build_error(ended.result.error, command)
    kind, message = DEVIATION, "the end of the run, or the sensors that were read, differ"
    if deviation := ended.deviation if isinstance(ended, ReplayResult) else ended.first_difference:
        message = deviation.lines[0]
    elif isinstance(ended, ReplayResult):
        kind, message = CHANGED, "the recording was changed after the run"
    return Problem(Verdict.FAILURE, kind, message, _add_command("\n".join(lines), command))


def _build_error(error: RobotcoreError, command: str) -> Problem:
    trace = error.traceback if isinstance(error, BehaviourError) else ""
    details = _add_command("\n".join(part for part in (str(error), trace) if part), command)
    return Problem(Verdict.ERROR, error.kind, str(error).partition("\n")[0], details)


def _add_command(text: str, command: str) -> str:
    return f"{text}\n\nRepeat the replay: {command}"

"""The result of a replay as a JUnit test suite with one case: the recording."""

from __future__ import annotations

from pathlib import Path

from robotcore.compatibility import read_version
from robotcore.errors import RobotcoreError
from robotcore.junit import JUnitCase, JUnitSuite, Problem, ProblemElement, build_error_problem
from robotcore.recording.replay import Evaluation, ReplayResult
from robotcore.view.text import list_differences, list_findings

GROUP = "replay"
"""The group of the case."""

DEVIATION = "deviation"
"""The kind of the problem of a decision that differs from the recorded one."""

CHANGED = "recording-changed"
"""The kind of the problem of a recording whose digest is not that of its decisions."""


def build_suite(file: Path, command: str, replay: ReplayResult | Evaluation) -> JUnitSuite:
    """Return a suite whose only case is a recording. It passes if the exit status of the replay is 0.

    file: the recording.
    command: the command line of the replay, which repeats it.
    """
    lines = list(list_findings(replay) if isinstance(replay, ReplayResult) else list_differences(replay))
    problem = _find_problem(replay, "\n".join(lines), command) if replay.exit_status else None
    output = "" if problem else "\n".join(lines)
    case = JUnitCase(GROUP, str(file), replay.result.wall_time_s, problem, output)
    return JUnitSuite(f"{GROUP} of {file}", [case], {"command": command, "robotcore": read_version()})


def _find_problem(replay: ReplayResult | Evaluation, findings: str, command: str) -> Problem:
    error = replay.result.error
    if isinstance(replay, Evaluation) and isinstance(error, RobotcoreError) and not replay.is_at_end:
        return build_error_problem(error, command)
    kind, message = DEVIATION, "the end of the run, or the sensors that were read, differ"
    if deviation := replay.deviation if isinstance(replay, ReplayResult) else replay.first_difference:
        message = deviation.lines[0]
    elif isinstance(replay, ReplayResult):
        kind, message = CHANGED, "the recording was changed after the run"
    return Problem(ProblemElement.FAILURE, kind, message, f"{findings}\n\nRepeat the command: {command}")
